// Changes OpenCV's log level and the number of its threads for several networks at once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/opencv_process.hpp"

#include <condition_variable>
#include <mutex>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>

namespace weir::engine {
namespace {

namespace logging = cv::utils::logging;

struct Shared {
  std::mutex mutex;  // of all but `entrance`
  int quiet = 0;
  logging::LogLevel level = logging::LOG_LEVEL_WARNING;

  std::mutex entrance;  // held by who waits to change the number: later runs wait for it
  std::condition_variable no_run;
  int runs = 0;
  int threads = cv::getNumThreads();
};
// Never destroyed: networks may still run when the program ends.
Shared& shared() {
  static Shared& shared = *new Shared;
  return shared;
}

}  // namespace

OpenCvQuiet::OpenCvQuiet() {
  const std::lock_guard lock(shared().mutex);
  if (shared().quiet++ == 0) shared().level = logging::setLogLevel(logging::LOG_LEVEL_SILENT);
}

OpenCvQuiet::~OpenCvQuiet() {
  const std::lock_guard lock(shared().mutex);
  if (--shared().quiet == 0) logging::setLogLevel(shared().level);
}

OpenCvThreads::OpenCvThreads(int threads) {
  const std::lock_guard entrance(shared().entrance);
  std::unique_lock lock(shared().mutex);
  if (threads != 0 && threads != shared().threads) {
    shared().no_run.wait(lock, [] { return shared().runs == 0; });
    cv::setNumThreads(threads);
    shared().threads = threads;
  }
  ++shared().runs;
}

OpenCvThreads::~OpenCvThreads() {
  const std::lock_guard lock(shared().mutex);
  if (--shared().runs == 0) shared().no_run.notify_one();
}

int OpenCvThreads::now() {
  const std::lock_guard lock(shared().mutex);
  return shared().threads;
}

}  // namespace weir::engine
