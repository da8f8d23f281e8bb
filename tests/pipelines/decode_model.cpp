// Runs a model on a raw picture and reads its outputs with a mode of tensor_decoder:
//   decode_model MODEL INPUT MODE SOURCE_WIDTH:SOURCE_HEIGHT SCALE_X:SCALE_Y [KEY=VALUE...]
// A pixel of the input is SCALE_X x SCALE_Y pixels of the source picture, whose top left corner is
// that of the input. Prints each result tensor as a line of JSON: columns, shape, numbers.
//   decode_model --heads
// Prints the name, the aliases and the settings of each head.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <list>

#include "core/decoders/decoders.hpp"
#include "core/direct/direct_model.hpp"
#include "core/heads/families.hpp"
#include "core/infer/module/decoder.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/tensor/element_type.hpp"
#include "core/tensor/tensor_header.hpp"
#include "core/text/text.hpp"
#include "weir/abi.h"
#include "weir/source_map.hpp"

namespace {

using namespace weir;
using Bytes = std::vector<char>;

[[noreturn]] void fail(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  std::exit(1);
}
template <class T>
T check(Result<T> result) {
  if (!result) fail(result.error());
  return *std::move(result);
}

struct Sink final : weir_sink {
  Status set_caps(const std::string& text) override {
    caps = text;
    return ok();
  }
  void* reserve(uint64_t bytes) override {
    memories.emplace_back(bytes);
    return memories.back().data();
  }
  Status share_input(uint32_t) override { return ok(); }
  std::string caps;
  std::list<Bytes> memories;
};

std::pair<double, double> parse_pair(const char* text) {
  const auto parts = split(text, ":");
  if (parts.size() != 2) std::exit(2);
  return {parse_double(parts[0]).value_or(0), parse_double(parts[1]).value_or(0)};
}

void print(const Bytes& memory, std::string_view columns) {
  const auto header = read_tensor_chunk(std::as_bytes(std::span(memory)));
  if (!header) std::exit(3);
  const auto& spec = header->spec;
  std::vector<uint32_t> shape;
  for (size_t i = 0; i < spec.shape.rank(); ++i) shape.push_back(spec.shape[i]);
  std::vector<double> numbers;
  visit_type(spec.type, [&]<class T>(std::type_identity<T>) {
    for (size_t at = kTensorHeaderBytes; at + sizeof(T) <= memory.size(); at += sizeof(T)) {
      T value;
      std::memcpy(&value, memory.data() + at, sizeof value);
      numbers.push_back(static_cast<double>(value));
    }
  });
  std::printf(
      "%s\n",
      nlohmann::json{{"columns", columns}, {"shape", shape}, {"numbers", numbers}}.dump().c_str());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--heads") {
    for (const heads::Family* family : heads::all_families())
      std::printf("%s|%s|%s|%g\n", family->name.data(), family->aliases.data(),
                  family->custom.data(), double{family->threshold});
    return 0;
  }
  if (argc < 6) return 2;
  const std::string path = argv[1];
  infer::OpenOptions request;
  request.paths = {path};
  const auto* engine = check(direct::engine_for("", request.paths));
  const auto model = check(direct::DirectModel::open(*engine, request));
  std::ifstream file(argv[2], std::ios::binary);
  Bytes pixels((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto inputs = model->inputs(), described = model->outputs();
  weir_tensor input{};
  input.info = inputs.at(0);
  for (uint32_t i = 0; i < input.info.rank; ++i)  // a batch of one where it is open
    if (input.info.shape[i] < 1) input.info.shape[i] = 1;
  input.data = pixels.data();
  input.bytes = input.capacity = pixels.size();
  const auto outcome = check(model->invoke({&input, 1}));

  infer::ModuleLibrary library;
  library.add_builtin(&decoders::builtin_decoders());
  infer::Decoder::Options options;
  for (int i = 6; i < argc; ++i) {
    const auto parts = split(argv[i], "=", 2);
    options.emplace_back(parts[0], parts.size() > 1 ? parts[1] : "");
  }
  const auto decoder = check(infer::Decoder::open(*check(library.decoder(argv[3])), options));
  const weir_stream_model facts{sizeof facts,
                                static_cast<uint32_t>(inputs.size()),
                                static_cast<uint32_t>(described.size()),
                                inputs.data(),
                                described.data(),
                                path.c_str(),
                                model->model().info().metadata_json,
                                nullptr,
                                0};
  decoder->set_model(&facts);
  // As caps have them: without names and quantisation.
  std::vector<weir_tensor> tensors = outcome.results.tensors();
  std::vector<weir_tensor_info> infos;
  for (auto& tensor : tensors) {
    tensor.info.name = nullptr, tensor.info.scale = 0, tensor.info.zero_point = 0;
    infos.push_back(tensor.info);
  }
  Sink sink;
  if (const auto status = decoder->configure(infos, &sink); !status) fail(status.error());

  SourceMap map;
  const auto [source_width, source_height] = parse_pair(argv[4]);
  std::tie(map.xx, map.yy) = parse_pair(argv[5]);
  map.source_width = static_cast<uint32_t>(source_width);
  map.source_height = static_cast<uint32_t>(source_height);
  const auto& shape = inputs[0].shape;  // outermost first: 1, 3, H, W or 1, H, W, 3
  const bool is_planar = shape[1] == 3;
  map.width = static_cast<uint32_t>(shape[is_planar ? 3 : 2]);
  map.height = static_cast<uint32_t>(shape[is_planar ? 2 : 1]);
  const weir_source_map abi = abi_map(map);
  weir_frame frame{};
  frame.struct_size = sizeof frame;
  frame.n_tensors = static_cast<uint32_t>(tensors.size());
  frame.tensors = tensors.data();
  frame.n_maps = 1;
  frame.maps = &abi;
  frame.maps_of = WEIR_MAPS_OF_TENSORS;
  if (const auto kept = decoder->decode(frame, &sink); !kept) fail(kept.error());

  const std::string field = "weir-columns=(string)\"";
  const size_t begin = sink.caps.find(field) + field.size();
  const auto columns =
      split(std::string_view(sink.caps).substr(begin, sink.caps.find('"', begin) - begin), ";");
  size_t index = 0;
  for (const Bytes& memory : sink.memories) print(memory, columns.at(index++));
  return 0;
}
