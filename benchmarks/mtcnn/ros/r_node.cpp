// R-Net as a node: /proposed in, /refined out. r MODELS
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "node.hpp"

namespace {

int run(int argc, char** argv) {
  if (argc < 2) return 2;
  cv::setNumThreads(1);
  ros::NodeHandle node;
  const auto part = control::r_part(argv[1]);
  const auto publisher = node.advertise<mtcnn_control::Regions>("refined", control::kWaiting);
  const auto take = [&](const mtcnn_control::RegionsPtr& message) {
    message->boxes = part->find(control::to_mat(message->picture), message->boxes);
    message->done.push_back(control::now());
    publisher.publish(*message);
  };
  control::wait_for_listener(publisher);
  const auto subscriber =
      control::subscribe<mtcnn_control::Regions>(node, "proposed", control::kWaiting, take);
  ros::spin();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "r");
  return control::guarded([&] { return run(argc, argv); });
}
