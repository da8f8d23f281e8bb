// DecodedClip: only decodes the pictures of a clip.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

typedef struct _GstElement GstElement;

namespace control {

// filesrc ! decodebin ! appsink. Several threads may pull pictures.
class DecodedClip {
 public:
  // Waits for the first picture, which is not counted, so that everything has started. Throws an
  // exception when none arrives.
  explicit DecodedClip(const std::string& file);
  ~DecodedClip();
  DecodedClip(const DecodedClip&) = delete;
  DecodedClip& operator=(const DecodedClip&) = delete;

  // Waits for the next picture and drops it; false at the end.
  bool next();

 private:
  GstElement *pipeline_, *sink_ = nullptr;
};

}  // namespace control
