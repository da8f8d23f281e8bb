// The properties of tensor_filter.
#pragma once
#include <cstdint>
#include <string>

namespace weir {

struct FilterSettings {
  bool silent = true;
  std::string framework = "auto";
  std::string model;
  std::string input, inputtype, inputname, inputlayout;
  std::string output, outputtype, outputname, outputlayout;
  std::string custom;
  int latency = 0;
  int throughput = 0;
  std::string input_combination;
  std::string output_combination;
  bool qos = false;
};

}  // namespace weir
