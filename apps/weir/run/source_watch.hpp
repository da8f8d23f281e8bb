// SourceWatch: when the sources of a pipeline delivered their last buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "run/diagnostics.hpp"

namespace weir::app {

// Thread-safe.
class SourceWatch {
 public:
  // Watches the sources that `pipeline` has and those that are added later.
  explicit SourceWatch(GstElement* pipeline);
  // The pipeline must be in state NULL: probes refer to this object.
  ~SourceWatch();
  SourceWatch(const SourceWatch&) = delete;
  SourceWatch& operator=(const SourceWatch&) = delete;

  // Keeps a warning of a source that it cannot read. Ignores other messages.
  void on_warning(GstMessage* warning);
  // Returns the warning of a source that has not connected again since: it added no pad, and all
  // that it delivered may have been on the way. The end of its stream is that of its connection.
  std::optional<Diagnostic> find_lost() const;

  // Returns the name of a camera or microphone that delivered nothing for `max_us` microseconds
  // and for two periods of its frame rate; "" if there is none. Counts from the first call. A
  // camera or microphone is a live source of video with a frame rate, of video over RTP, or of
  // raw audio. Call it from one thread.
  std::string find_silent(gint64 max_us) const;

 private:
  struct Stream;
  struct Loss {
    gint64 time = 0;  // monotonic microseconds
    gst::Ref<GstElement> source;
    Diagnostic warning;
  };
  void watch(GstElement* element);
  void watch(GstElement* source, GstPad* pad);

  gst::Ref<GstElement> pipeline_;
  mutable std::mutex mutex_;                      // guards what follows
  std::vector<std::unique_ptr<Stream>> streams_;  // exist as long as probes may run
  std::vector<Loss> losses_;
};

}  // namespace weir::app
