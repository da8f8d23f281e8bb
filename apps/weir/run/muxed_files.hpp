// MuxedFiles: the files that the muxers of a pipeline write. A muxer writes the index of its file
// at EOS, and many players need it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <set>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::app {

bool is_muxer(GstElement* element);
// A bin has the sink flag when a child has it: only the child is one.
bool is_sink(GstElement* element);

class MuxedFiles {
 public:
  // Finds the muxers of `pipeline` and the sinks downstream of them that are in PLAYING.
  explicit MuxedFiles(GstElement* pipeline);

  // Lists the paths (get_path()) of the sinks that EOS can still reach and has not passed. `failed`
  // are the paths of elements that posted errors.
  std::vector<std::string> unfinished(const std::set<std::string>& failed) const;
  // Tells whether an element with this path is a muxer, a sink downstream of one, or between them.
  bool contain(const std::string& path) const;
  // Sends EOS to the muxers themselves, in other threads. For a stream whose sources do not end.
  void send_eos() const;

 private:
  struct File {
    gst::Ref<GstElement> sink;
    std::vector<std::string> elements;  // paths, from the muxer to the sink
  };
  void add(GstPad* source, std::vector<std::string>* elements, std::set<GstPad*>* visited);

  std::vector<gst::Ref<GstElement>> muxers_;
  std::vector<File> files_;
};

}  // namespace weir::app
