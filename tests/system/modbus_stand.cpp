// A box without cameras: serves one epoch that does not change on a free port of loopback, prints the port,
// and ends with its standard input.
#include <cstdio>

#include "drivers/modbus/modbus_server.h"
#include "firmware/publish/modbus_reply.h"

namespace {

constexpr adit::base::TimeNs kNowNs = 1'700'000'000 * adit::base::kNsPerS;

class Stand final : public adit::hal::RequestHandler {
 public:
  Stand() {
    adit::publish::BoxCondition box;
    box.epoch = 77;
    box.initialised = box.georeferenced = true;
    adit::georef::GeoFix fix;
    fix.state.points.status = adit::stereo::FixStatus::kTracked;
    fix.state.mid_exposure_ns = kNowNs;
    fix.position_s_m = Eigen::Vector3d(12.3456, -0.9, 4000);
    map_.Update(adit::publish::MakeEpoch(&fix, box, {}, kNowNs), box, {}, {}, kNowNs);
  }
  std::size_t Answer(std::span<const std::uint8_t> request, std::span<std::uint8_t> reply) override {
    return responder_.Answer(request, reply, kNowNs);
  }

 private:
  adit::publish::RegisterMap map_{adit::publish::MakeIdentity("4711", "1.2.3", 0), {}};
  adit::publish::ModbusResponder responder_{map_, 1};
};

}  // namespace

int main() {
  Stand stand;
  adit::modbus::ServerOptions options;
  options.bind = "127.0.0.1";
  options.port = 0;
  const auto server = adit::modbus::ModbusServer::Open(options, stand);
  if (!server) {
    std::fprintf(stderr, "%s\n", server.error().Line().c_str());
    return 1;
  }
  std::printf("%d\n", (*server)->Port());
  std::fflush(stdout);
  while (std::getchar() != EOF) {
  }
  return 0;
}
