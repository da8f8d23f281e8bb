// O-Net as a node: /refined in, /faces out. o MODELS [--report FILE] [--faces FILE]. The files
// receive the times and the faces of each picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <CLI/CLI.hpp>
#include <fstream>

#include "node.hpp"

namespace {

int64_t ns(const ros::Time& time) {
  return static_cast<int64_t>(time.toNSec());
}

// A message is copied four times: serialised, into and out of the socket, deserialised. This
// applies to the picture from the camera to P, and to the picture with its regions to R and to O.
// Before that, the picture is copied into the camera's message.
uint64_t copied(const mtcnn_control::Regions& message) {
  const uint64_t picture = ros::serialization::serializationLength(message.picture);
  return 5 * picture + 2 * 4 * ros::serialization::serializationLength(message);
}

int run(int argc, char** argv) {
  std::string models, report, file;
  CLI::App app{"O-Net as a node"};
  app.add_option("MODELS", models, "The folder of the networks' files")->required();
  app.add_option("--report", report, "A file for the times of each picture, as JSON");
  app.add_option("--faces", file, "A file for a JSON list of faces for each picture");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  ros::NodeHandle node;
  const auto part = control::o_part(models);
  control::Times times;
  std::ofstream text;
  if (!file.empty()) text.open(file);
  const auto publisher = node.advertise<mtcnn_control::Faces>("faces", control::kWaiting);
  const auto take = [&](const mtcnn_control::RegionsPtr& message) {
    mtcnn_control::Faces out;
    out.faces = part->find(control::to_mat(message->picture), message->boxes);
    out.header = message->header;
    times.picture(ns(message->header.stamp), ns(message->done.at(0)), ns(message->done.at(1)),
                  ns(control::now()));
    times.copied(copied(*message));
    if (text.is_open()) text << control::to_json(out.faces) << std::endl;
    publisher.publish(out);
  };
  control::wait_for_listener(publisher);
  const auto subscriber =
      control::subscribe<mtcnn_control::Regions>(node, "refined", control::kWaiting, take);
  ros::spin();
  return report.empty() || times.write(report) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "o");
  return control::guarded([&] { return run(argc, argv); });
}
