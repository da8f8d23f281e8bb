// Test program: runs a model once and prints what a mode of tensor_decoder finds, as JSON.
//
//   results_program MODEL MODE INPUT TYPE DIMENSIONS [OPTION=VALUE...]
//
// INPUT is a file with the elements, TYPE and DIMENSIONS are as in caps. Positions are pixels of
// the model's input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/decoders/results_test_support.hpp"
#include "core/tensor/element_type.hpp"
#include "weir/model.hpp"

namespace {

using weir::decoders::ResultsRun;
using weir::decoders::TestTensor;

int fail(const std::string& error) {
  std::cerr << error << "\n";
  return 1;
}

std::string format_dimensions(const weir::TensorShape& shape) {
  std::string out;
  for (auto extent = shape.rbegin(); extent != shape.rend(); ++extent)
    out += (out.empty() ? "" : ":") + std::to_string(*extent);
  return out.empty() ? "1" : out;
}

nlohmann::json to_json(const weir::ResultRow& row) {
  nlohmann::json out{{"score", row.score()}, {"class", row.class_index()}};
  if (row.has_box()) {
    const weir::Box box = row.box();
    out["box"] = {box.x1, box.y1, box.x2, box.y2};
    out["rotation"] = row.rotation();
  }
  for (uint32_t i = 0; i < row.n_points(); ++i)
    out["points"].push_back({row.x(i), row.y(i), row.point_score(i)});
  return out;
}

nlohmann::json to_json(ResultsRun& run) {
  nlohmann::json rows = nlohmann::json::array();
  for (size_t i = 0; i < run.n_rows(); ++i) {
    if (run.row(i).is_background()) continue;
    rows.push_back(to_json(run.row(i)));
    for (const auto& tensor : run.results) {
      if (tensor.columns.kind != WEIR_RESULT_TEXT) continue;
      const char* text = reinterpret_cast<const char*>(tensor.payload.data());
      const size_t length = tensor.spec.shape[0];
      rows.back()["text"] = std::string(text + i * length, strnlen(text + i * length, length));
    }
  }
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return fail("usage: results_program MODEL MODE INPUT TYPE DIMENSIONS [KEY=VALUE]");
  const std::string path = argv[1], dimensions = argv[5];
  auto model = weir::Model::open(path);
  if (!model) return fail(model.error().message());
  std::ifstream file(argv[3], std::ios::binary);
  const weir::decoders::Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  const auto type = weir::parse_element_type(argv[4]);
  if (type == weir::ElementType::End) return fail("no such type");
  const auto info = TestTensor(type, dimensions, bytes).info();
  const weir::TensorShape shape(info.shape, info.shape + info.rank);
  if (const auto status = model->reshape({shape}); !status) return fail(status.error().message());
  const auto outputs = model->invoke(
      {weir::TensorView(bytes.data(), bytes.size(), static_cast<uint32_t>(type), shape)});
  if (!outputs) return fail(outputs.error().message());

  weir::decoders::TestModel facts{.path = path, .metadata = model->metadata(), .input = dimensions};
  std::vector<TestTensor> tensors;
  for (size_t i = 0; i < outputs->size(); ++i) {
    const auto output = (*outputs)[i];
    const auto described = output.info();
    const auto* data = reinterpret_cast<const uint8_t*>(output.bytes().data());
    tensors.emplace_back(static_cast<weir::ElementType>(described.type),
                         format_dimensions(described.shape),
                         weir::decoders::Bytes(data, data + output.bytes().size()));
    facts.names.push_back(described.name);
    facts.scales.push_back(described.scale);
    facts.zero_points.push_back(described.zero_point);
  }
  weir::decoders::DecoderOptions options;
  for (int i = 6; i < argc; ++i) {
    const std::string option = argv[i];
    const size_t at = option.find('=');
    options.emplace_back(option.substr(0, at), at < option.size() ? option.substr(at + 1) : "");
  }
  ResultsRun run(argv[2], options);
  if (run.configure(tensors, &facts)) run.decode(tensors);
  if (!run.error.empty()) return fail(run.error);
  std::cout << to_json(run) << "\n";
  return 0;
}
