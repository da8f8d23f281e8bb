// Shared by the nodes: the clock, pictures of messages, waiting for subscribers, subscribing.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <mtcnn_control/Faces.h>
#include <mtcnn_control/Regions.h>
#include <ros/ros.h>

#include <chrono>
#include <cstdio>

#include "parts.hpp"

namespace control {

constexpr uint32_t kWaiting = 8;  // messages between two nodes

// The monotonic clock, which is the same for all processes of a machine, as ROS time.
inline ros::Time now() {
  const auto time = std::chrono::steady_clock::now().time_since_epoch();
  return ros::Time().fromNSec(
      static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(time).count()));
}

// Shares the message's memory.
inline cv::Mat to_mat(sensor_msgs::Image& image) {
  return {static_cast<int>(image.height), static_cast<int>(image.width), CV_8UC3, image.data.data(),
          image.step};
}

// Waits for a subscriber: a node accepts pictures only once its results will be received.
inline void wait_for_listener(const ros::Publisher& publisher) {
  while (ros::ok() && publisher.getNumSubscribers() == 0) ros::WallDuration(0.02).sleep();
}

// Messages are sent immediately (no Nagle delay) and the function may modify them.
template <class Message>
ros::Subscriber subscribe(ros::NodeHandle& node, const std::string& topic, uint32_t waiting,
                          boost::function<void(const boost::shared_ptr<Message>&)> take) {
  return node.subscribe<Message, const boost::shared_ptr<Message>&>(
      topic, waiting, take, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

// Runs a node; an exception ends it with a line on stderr and exit status 1.
template <class F>
int guarded(F node) {
  try {
    return node();
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", ros::this_node::getName().c_str(), e.what());
    return 1;
  }
}

}  // namespace control
