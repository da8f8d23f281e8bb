// The camera as a node: publishes the pictures of a file as /pictures. camera [--live] [--rate N]
// INPUT. Without --live at most four pictures are in flight: the next is sent when /faces reports
// that one is done. With --live they are sent at the clip's rate, and slow subscribers miss some.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <CLI/CLI.hpp>
#include <condition_variable>
#include <mutex>

#include "../pictures.hpp"
#include "node.hpp"

namespace {

using namespace std::chrono_literals;

constexpr size_t kUnderWay = 4;  // one per node and one waiting

class Camera {
 public:
  explicit Camera(bool live)
      : live_(live),
        publisher_(node_.advertise<sensor_msgs::Image>("pictures", live ? 1 : kUnderWay)),
        subscriber_(control::subscribe<mtcnn_control::Faces>(
            node_, "faces", control::kWaiting,
            [this](const mtcnn_control::FacesPtr&) { done(); })) {}
  void wait_for_listener() { control::wait_for_listener(publisher_); }
  void send(const cv::Mat& picture) {
    sensor_msgs::Image image;
    image.header.stamp = control::now();
    image.height = static_cast<uint32_t>(picture.rows);
    image.width = static_cast<uint32_t>(picture.cols);
    image.encoding = "rgb8";
    image.step = static_cast<uint32_t>(picture.step);
    image.data.assign(picture.datastart, picture.dataend);
    if (!live_) wait_until([this] { return sent_ - done_ < kUnderWay; });
    ++sent_;
    publisher_.publish(image);
  }
  // Waits for the pictures in flight; some live pictures are never finished.
  void finish() {
    if (live_)
      ros::WallDuration(0.5).sleep();
    else
      wait_until([this] { return done_ == sent_; });
  }

 private:
  template <class F>
  void wait_until(F condition) {
    std::unique_lock<std::mutex> lock(mutex_);
    while (ros::ok() && !condition()) changed_.wait_for(lock, 100ms);
  }
  void done() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++done_;
    changed_.notify_one();
  }
  const bool live_;
  ros::NodeHandle node_;
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
  std::mutex mutex_;
  std::condition_variable changed_;
  size_t sent_ = 0;  // used by the decoder's thread only
  size_t done_ = 0;  // guarded by mutex_
};

int run(int argc, char** argv) {
  gst_init(&argc, &argv);
  control::Source source;
  CLI::App app{"The pictures of a file as a topic"};
  app.add_option("INPUT", source.file, "A photo or a video")->required();
  app.add_option("--rate", source.rate, "Pictures per second, where the clip has more");
  app.add_flag("--live", source.live, "Pictures come at the rate of the clip");
  CLI11_PARSE(app, argc, argv);
  Camera camera(source.live);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  camera.wait_for_listener();
  const bool all = control::for_each_picture(
      source, [&](const cv::Mat& picture, int64_t) { camera.send(picture); });
  camera.finish();
  return all ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "camera");
  return control::guarded([&] { return run(argc, argv); });
}
