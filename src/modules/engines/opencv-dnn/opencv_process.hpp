// What OpenCV has once for the whole process: its log level and the number of its threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

// In a library of its own, because the modules of the three formats share it.
#define WEIR_OPENCV_SHARED __attribute__((visibility("default")))

namespace weir::engine {

// While one exists, OpenCV logs nothing: it prints what it throws, and our error is clearer.
class WEIR_OPENCV_SHARED OpenCvQuiet {
 public:
  OpenCvQuiet();
  ~OpenCvQuiet();
  OpenCvQuiet(const OpenCvQuiet&) = delete;
  OpenCvQuiet& operator=(const OpenCvQuiet&) = delete;
};

// Held while a network runs. 0: with the number that is set. When the number changes, OpenCV ends
// its threads, also those that another network uses: a network of another number waits until none
// runs, and networks that come later wait for it.
class WEIR_OPENCV_SHARED OpenCvThreads {
 public:
  explicit OpenCvThreads(int threads);
  ~OpenCvThreads();
  OpenCvThreads(const OpenCvThreads&) = delete;
  OpenCvThreads& operator=(const OpenCvThreads&) = delete;
  static int now();  // the number that is set
};

}  // namespace weir::engine
