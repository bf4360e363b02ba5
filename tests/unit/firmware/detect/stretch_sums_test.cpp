#include "firmware/detect/stretch_sums.h"

#include <array>
#include <cstring>
#include <random>

#include <CppUTest/TestHarness.h>

using adit::detect::kStretchPx;
using adit::detect::StretchSums;

namespace {

void CheckSame(const StretchSums& a, const StretchSums& b) {
  LONGS_EQUAL(a.g, b.g);
  LONGS_EQUAL(a.k, b.k);
  LONGS_EQUAL(a.kk, b.kk);
  LONGS_EQUAL(a.most, b.most);
}

}  // namespace

TEST_GROUP(StretchSums){};

TEST(StretchSums, OfThreePixelsByHand) {
  std::array<std::uint8_t, kStretchPx> pixels{13, 10, 15, 200, 200};
  for (const auto sum : {adit::detect::SumStretchPlain8, adit::detect::SumStretchWide8})
    CheckSame({17, 19, 35, 15}, sum(pixels.data(), 3, 7));  // 6 3 8
  const std::array<std::uint16_t, 3> wide{1003, 1000, 4095};
  std::array<std::uint8_t, sizeof wide> bytes;
  std::memcpy(bytes.data(), wide.data(), sizeof wide);
  CheckSame({3 + 0 + 3095, 2 * 3095, 4 * 3095, 4095}, adit::detect::SumStretchPlain16(bytes.data(), 3, 1000));
}

TEST(StretchSums, TheWideOnesEqualThePlainOnesWhateverFollows_Seed1) {
  std::mt19937 random(1);
  std::array<std::uint8_t, kStretchPx> pixels;
  for (int round = 0; round < 20000; ++round) {
    const int threshold = static_cast<int>(random() % 255),
              count = 1 + static_cast<int>(random() % kStretchPx);
    for (int i = 0; i < kStretchPx; ++i) {
      const auto least = static_cast<unsigned>(i < count ? threshold + 1 : 0);
      pixels[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(least + random() % (256 - least));
    }
    CheckSame(adit::detect::SumStretchPlain8(pixels.data(), count, threshold),
              adit::detect::SumStretchWide8(pixels.data(), count, threshold));
  }
}
