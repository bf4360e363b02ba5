#include "drivers/aravis/session.h"

#include "drivers/aravis/features.h"

namespace adit::aravis {
namespace {

constexpr int kUdpSocketBytes =
    4 << 20;  // with less, the kernel drops most of a frame while we are scheduled out
// A missing packet is asked for after this long: a few times the packet spacing, well below the frame period.
constexpr guint kPacketTimeoutUs = 5'000;
// A frame whose packets do not come is given up after this long, or it would hold back the complete ones
// behind it.
constexpr guint kFrameRetentionUs = 80'000;

/// Called from Aravis' receiving thread: no lock, no heap once it runs.
void OnStreamEvent(void* settings, ArvStreamCallbackType type, ArvBuffer* buffer) {
  if (type == ARV_STREAM_CALLBACK_TYPE_INIT) {
    const auto& prepare = static_cast<const AravisSettings*>(settings)->prepare_receiving;
    if (prepare) prepare();
  }
  if (type != ARV_STREAM_CALLBACK_TYPE_BUFFER_DONE || buffer == nullptr) return;
  auto* const slot = static_cast<Slot*>(const_cast<void*>(arv_buffer_get_user_data(buffer)));
  // relaxed: a lone time stamp.
  slot->done_ns.store(slot->clock->Now(), std::memory_order_relaxed);
}

/// Called from Aravis' heartbeat thread.
void OnControlLost(ArvGvDevice* /*device*/, std::atomic<bool>* lost) {
  lost->store(true, std::memory_order_relaxed);
}

const char* PixelFormatName(int bits) { return bits == 8 ? "Mono8" : bits == 10 ? "Mono10" : "Mono12"; }

}  // namespace

base::Error Session::Failed(const std::string& step, GError* error) const {
  const std::string reason = error != nullptr ? error->message : "no reason given";
  g_clear_error(&error);
  return {base::ErrorCode::kUnavailable, "camera " + settings_.device, step + ": " + reason};
}

bool Session::Has(const char* feature) const {
  return arv_camera_is_feature_available(camera_.get(), feature, nullptr) != FALSE;
}

base::Result<std::unique_ptr<Session>> Session::Open(const AravisSettings& settings,
                                                     const std::vector<std::unique_ptr<Slot>>& slots) {
  std::unique_ptr<Session> session(new Session(settings));
  GError* error = nullptr;
  session->camera_.reset(arv_camera_new(settings.device.c_str(), &error));
  if (!session->camera_) return session->Failed("is not there", error);
  g_signal_connect(arv_camera_get_device(session->camera_.get()), "control-lost", G_CALLBACK(OnControlLost),
                   &session->lost_);
  if (auto configured = session->Configure(); !configured) return configured.error();
  if (auto started = session->StartStream(slots); !started) return started.error();
  return session;
}

Session::~Session() {
  if (camera_) arv_camera_stop_acquisition(camera_.get(), nullptr);
  stream_.reset();  // joins the receiving thread: no callback after this
  if (camera_) g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera_.get()), &lost_);
}

base::Result<void> Session::Configure() {
  GError* error = nullptr;
  if (auto image = ConfigureImage(); !image) return image;
  if (auto trigger = ConfigureTrigger(); !trigger) return trigger;
  if (arv_camera_is_gv_device(camera_.get())) {
    arv_camera_gv_set_packet_size(camera_.get(), settings_.packet_size, &error);
    if (error != nullptr) return Failed("packet size " + std::to_string(settings_.packet_size), error);
    arv_camera_gv_set_stream_options(camera_.get(), settings_.packet_socket
                                                        ? ARV_GV_STREAM_OPTION_NONE
                                                        : ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
  }
  const auto available = [this](const char* name) { return Has(name); };
  if (const auto* enable = FirstAvailable(kPtpEnableNames, available); settings_.ptp && enable != nullptr) {
    arv_camera_set_boolean(camera_.get(), *enable, TRUE, nullptr);
  }
  if (const auto* status = FirstAvailable(kPtpStatusNames, available); settings_.ptp && status != nullptr) {
    const char* const state = arv_camera_get_string(camera_.get(), *status, nullptr);
    ptp_locked_ = state != nullptr && PtpStateIsLocked(state);
  }
  return {};
}

base::Result<void> Session::ConfigureImage() {
  GError* error = nullptr;
  arv_camera_set_string(camera_.get(), "PixelFormat", PixelFormatName(settings_.bits), &error);
  if (error != nullptr) return Failed(std::string("PixelFormat ") + PixelFormatName(settings_.bits), error);
  int width_px = 0, height_px = 0;
  arv_camera_get_sensor_size(camera_.get(), &width_px, &height_px, &error);
  if (error != nullptr) return Failed("sensor size", error);
  if (width_px < settings_.width_px || height_px < settings_.height_px) {
    return base::Error{base::ErrorCode::kUnavailable, "camera " + settings_.device,
                       "has a sensor of " + std::to_string(width_px) + " x " + std::to_string(height_px) +
                           " px; the rig asks for " + std::to_string(settings_.width_px) + " x " +
                           std::to_string(settings_.height_px)};
  }
  arv_camera_set_integer(camera_.get(), "Width", settings_.width_px, &error);
  if (error == nullptr) arv_camera_set_integer(camera_.get(), "Height", settings_.height_px, &error);
  if (error != nullptr) {
    return Failed(
        "image size " + std::to_string(settings_.width_px) + " x " + std::to_string(settings_.height_px),
        error);
  }
  const auto available = [this](const char* name) { return Has(name); };
  const FeatureName* const exposure = FirstAvailable(kExposureNames, available);
  if (exposure == nullptr)
    return Failed("has no feature ExposureTime, ExposureTimeAbs or ExposureTimeRaw", nullptr);
  if (exposure->kind == ValueKind::kFloat) {
    arv_camera_set_float(camera_.get(), exposure->name, settings_.exposure_us, &error);
  } else {
    arv_camera_set_integer(camera_.get(), exposure->name, static_cast<gint64>(settings_.exposure_us), &error);
  }
  if (error != nullptr)
    return Failed(std::string(exposure->name) + " " + std::to_string(settings_.exposure_us) + " us", error);
  if (const FeatureName* const gain = FirstAvailable(kGainNames, available)) {
    arv_camera_set_float(camera_.get(), gain->name, settings_.gain_db, &error);
    if (error != nullptr)
      return Failed(std::string(gain->name) + " " + std::to_string(settings_.gain_db) + " dB", error);
  }
  return {};
}

base::Result<void> Session::ConfigureTrigger() {
  GError* error = nullptr;
  if (Has("TriggerSelector")) arv_camera_set_string(camera_.get(), "TriggerSelector", "FrameStart", &error);
  if (error == nullptr) arv_camera_set_string(camera_.get(), "TriggerMode", "On", &error);
  if (error == nullptr)
    arv_camera_set_string(camera_.get(), "TriggerSource", settings_.trigger_source.c_str(), &error);
  if (error != nullptr) return Failed("trigger from " + settings_.trigger_source, error);
  arv_camera_set_acquisition_mode(camera_.get(), ARV_ACQUISITION_MODE_CONTINUOUS, &error);
  if (error != nullptr) return Failed("AcquisitionMode Continuous", error);
  return {};
}

base::Result<void> Session::StartStream(const std::vector<std::unique_ptr<Slot>>& slots) {
  GError* error = nullptr;
  stream_.reset(arv_camera_create_stream(camera_.get(), OnStreamEvent, &settings_, &error));
  if (!stream_) return Failed("stream", error);
  if (ARV_IS_GV_STREAM(stream_.get())) {
    g_object_set(stream_.get(), "packet-timeout", kPacketTimeoutUs, "frame-retention", kFrameRetentionUs,
                 nullptr);
    if (!settings_.packet_socket) {
      g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                   kUdpSocketBytes, nullptr);
    }
  }
  for (const auto& slot : slots) {
    if (!slot->with_stages) Push(*slot);
  }
  arv_camera_start_acquisition(camera_.get(), &error);
  if (error != nullptr) return Failed("AcquisitionStart", error);
  return {};
}

void Session::Push(Slot& slot) const {
  // A callback that came after its frame was taken must not date the next one. relaxed: as in Describe.
  slot.done_ns.store(base::kNever, std::memory_order_relaxed);
  // Aravis writes the id when the leader comes: 0, never used, says that it did not.
  arv_buffer_set_frame_id(slot.buffer.get(), 0);
  // The stream takes a reference of its own: ours keeps the buffer over a lost connection.
  arv_stream_push_buffer(stream_.get(), static_cast<ArvBuffer*>(g_object_ref(slot.buffer.get())));
}

std::uint64_t Session::Resent() const {
  guint64 resent = 0, missing = 0;
  if (ARV_IS_GV_STREAM(stream_.get()))
    arv_gv_stream_get_statistics(ARV_GV_STREAM(stream_.get()), &resent, &missing);
  return resent;
}

std::uint64_t Session::Underruns() const {
  guint64 completed = 0, failures = 0, underruns = 0;
  arv_stream_get_statistics(stream_.get(), &completed, &failures, &underruns);
  return underruns;
}

}  // namespace adit::aravis
