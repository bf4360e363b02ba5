// Runs a fuzz target without a fuzzing engine: random bytes, and the same input with a few bytes changed. A
// fixed seed: the same run everywhere. With clang and ADIT_FUZZ the engine takes this one's place.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

constexpr unsigned kSeed = 20'260'101;
constexpr std::size_t kLengthMax = 600;
constexpr int kChildren = 20;  // changed copies of each random input

std::uint8_t Byte(std::mt19937& random) {
  // Small numbers and the edges are what formats are made of.
  constexpr std::uint8_t kEdges[] = {0, 1, 2, 3, 4, 6, 0x0E, 0x2B, 0x7F, 0x80, 0xFF};
  const auto draw = static_cast<unsigned>(random());
  return draw % 2 == 0 ? kEdges[draw / 2 % sizeof kEdges] : static_cast<std::uint8_t>(draw >> 24);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 1000;
  std::mt19937 random(kSeed);
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint8_t> input(random() % kLengthMax);
    for (std::uint8_t& byte : input) byte = Byte(random);
    (void)LLVMFuzzerTestOneInput(input.data(), input.size());
    for (int child = 0; child < kChildren && !input.empty(); ++child) {
      for (int change = 0; change <= child % 3; ++change) input[random() % input.size()] = Byte(random);
      (void)LLVMFuzzerTestOneInput(input.data(), input.size());
    }
  }
  std::printf("%d inputs, seed %u\n", rounds * (kChildren + 1), kSeed);
  return 0;
}
