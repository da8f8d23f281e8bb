// P-Net as a node: /pictures in, /proposed out. p MODELS MIN_FACE WAITING
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "node.hpp"

namespace {

int run(int argc, char** argv) {
  if (argc < 4) return 2;
  cv::setNumThreads(1);
  ros::NodeHandle node;
  const auto part = control::p_part(argv[1], static_cast<uint32_t>(std::stoul(argv[2])));
  const auto publisher = node.advertise<mtcnn_control::Regions>("proposed", control::kWaiting);
  const auto take = [&](const sensor_msgs::ImagePtr& picture) {
    mtcnn_control::Regions out;
    out.boxes = part->find(control::to_mat(*picture), {});
    out.header = picture->header;
    out.picture = std::move(*picture);  // forwarded without a copy
    out.done.push_back(control::now());
    publisher.publish(out);
  };
  control::wait_for_listener(publisher);
  const auto subscriber = control::subscribe<sensor_msgs::Image>(
      node, "pictures", static_cast<uint32_t>(std::stoul(argv[3])), take);
  ros::spin();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "p");
  return control::guarded([&] { return run(argc, argv); });
}
