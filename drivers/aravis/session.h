// One connection to a camera, from opening to losing it.
#pragma once

#include <arv.h>

#include <atomic>
#include <memory>
#include <vector>

#include "drivers/aravis/aravis_camera.h"
#include "drivers/linux/huge_memory.h"
#include "firmware/base/result.h"

namespace adit::aravis {

/// Releases a GObject.
struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <class T>
using Owned = std::unique_ptr<T, Unref>;

/// A buffer of the pool. Lives as long as the camera object, over all connections.
struct Slot {
  linux::HugeMemory memory;
  Owned<ArvBuffer> buffer;
  std::atomic<base::TimeNs> done_ns{base::kNever};  ///< written by Aravis' receiving thread
  bool with_stages = false;           ///< Wait's thread only: handed out and not yet pushed again
  std::atomic<bool> released{false};  ///< set by Release, taken by Wait's thread
  const hal::Clock* clock = nullptr;
};

/// An open, configured, acquiring camera.
class Session {
 public:
  /// Opens and starts; all slots that are not with the stages go into the stream. Declines with device and
  /// step.
  static base::Result<std::unique_ptr<Session>> Open(const AravisSettings& settings,
                                                     const std::vector<std::unique_ptr<Slot>>& slots);
  ~Session();

  ArvStream* Stream() const { return stream_.get(); }
  bool Lost() const { return lost_.load(std::memory_order_relaxed); }  // relaxed: a lone flag
  bool PtpLocked() const { return ptp_locked_; }
  void Push(Slot& slot) const;
  std::uint64_t Resent() const;
  std::uint64_t Underruns() const;

 private:
  explicit Session(const AravisSettings& settings) : settings_(settings) {}
  base::Result<void> Configure();
  base::Result<void> ConfigureImage();
  base::Result<void> ConfigureTrigger();
  base::Result<void> StartStream(const std::vector<std::unique_ptr<Slot>>& slots);
  bool Has(const char* feature) const;
  base::Error Failed(const std::string& step, GError* error) const;

  AravisSettings settings_;
  Owned<ArvCamera> camera_;
  Owned<ArvStream> stream_;
  std::atomic<bool> lost_{false};
  bool ptp_locked_ = false;
};

}  // namespace adit::aravis
