// The pictures of a clip, decoded and nothing more.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

typedef struct _GstElement GstElement;

namespace control {

// filesrc ! decodebin ! appsink. Pictures may be taken by several threads.
class DecodedClip {
 public:
  // Waits for the first picture, which does not count: by then everything has started. An exception
  // where none comes.
  explicit DecodedClip(const std::string& file);
  ~DecodedClip();
  DecodedClip(const DecodedClip&) = delete;
  DecodedClip& operator=(const DecodedClip&) = delete;

  // Waits for the next picture and lets it go; false at the end.
  bool next();

 private:
  GstElement *pipeline_, *sink_ = nullptr;
};

}  // namespace control
