// Measures writing and parsing one frame as a message against the bare libraries: the classes that
// protoc and flatc make of the schemas, and FlexBuffers' builder and references. Both sides read or
// write the same fields of the same frame. Minimum of interleaved rounds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <flatbuffers/flexbuffers.h>

#include <cstdlib>
#include <cstring>
#include <new>

#include "messages/flatbuf_message.hpp"
#include "messages/flexbuf_message.hpp"
#include "messages/protobuf_message.hpp"
#include "rounds.hpp"
#include "tensors.pb.h"
#include "tensors_generated.h"

namespace {

using namespace weir::messages;
namespace flat = nnstreamer::flatbuf;
namespace proto = nnstreamer::protobuf;

// Memory of a message, as a stream has it: aligned, used again.
class Room {
 public:
  std::byte* reserve(size_t bytes) {
    size_ = bytes;
    return memory_;
  }
  std::span<const std::byte> message() const { return {memory_, size_}; }

 private:
  static constexpr size_t kBytes = 1 << 20;
  std::byte* const memory_ = static_cast<std::byte*>(std::aligned_alloc(64, kBytes));
  size_t size_ = 0;
};

uint64_t seen = 0;  // what the compiler must not leave out
void use(const MessageTensor& tensor) {
  seen += tensor.type + tensor.dimensions[1] + tensor.data.size() +
          static_cast<uint64_t>(tensor.data.back());
}

struct BareProtobuf {
  using Ours = ProtobufMessage;
  proto::Tensors message;  // keeps its memory
  void write(const TensorMessage& from, Room* room) {
    message.Clear();
    message.set_num_tensor(static_cast<uint32_t>(from.tensors.size()));
    message.mutable_fr()->set_rate_n(from.rate_n);
    message.mutable_fr()->set_rate_d(from.rate_d);
    for (const auto& tensor : from.tensors) {
      auto* to = message.add_tensor();
      to->set_type(static_cast<proto::Tensor::Tensor_type>(tensor.type));
      for (const uint32_t d : tensor.dimensions) to->add_dimension(d);
      to->set_data(tensor.data.data(), tensor.data.size());
    }
    const size_t size = message.ByteSizeLong();
    message.SerializeToArray(room->reserve(size), static_cast<int>(size));
  }
  void parse(std::span<const std::byte> bytes) {
    if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) std::abort();
    for (const auto& from : message.tensor()) {
      MessageTensor tensor;
      tensor.type = static_cast<uint32_t>(from.type());
      std::copy(from.dimension().begin(), from.dimension().end(), tensor.dimensions.begin());
      tensor.data = std::as_bytes(std::span(from.data()));
      use(tensor);
    }
  }
};

struct BareFlatbuf {
  using Ours = FlatbufMessage;
  flatbuffers::FlatBufferBuilder builder;
  // The message stays in the builder, without a copy to the stream.
  void write(const TensorMessage& from, Room*) {
    builder.Clear();
    std::vector<flatbuffers::Offset<flat::Tensor>> all;
    for (const auto& tensor : from.tensors) {
      const auto data = builder.CreateVector(reinterpret_cast<const uint8_t*>(tensor.data.data()),
                                             tensor.data.size());
      const auto dimensions =
          builder.CreateVector(tensor.dimensions.data(), tensor.dimensions.size());
      all.push_back(flat::CreateTensor(builder, builder.CreateString(""),
                                       static_cast<flat::Tensor_type>(tensor.type), dimensions,
                                       data));
    }
    const flat::frame_rate rate(from.rate_n, from.rate_d);
    builder.Finish(flat::CreateTensorsDirect(builder, static_cast<int>(all.size()), &rate, &all));
    seen += builder.GetSize();
  }
  void parse(std::span<const std::byte> bytes) {
    const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
    flatbuffers::Verifier verifier(data, bytes.size());
    if (!flat::VerifyTensorsBuffer(verifier)) std::abort();
    for (const auto* from : *flat::GetTensors(data)->tensor()) {
      MessageTensor tensor;
      tensor.type = static_cast<uint32_t>(from->type());
      std::copy(from->dimension()->begin(), from->dimension()->end(), tensor.dimensions.begin());
      tensor.data = std::as_bytes(std::span(from->data()->data(), from->data()->size()));
      use(tensor);
    }
  }
};

struct BareFlexbuf {
  using Ours = FlexbufMessage;
  flexbuffers::Builder builder;
  std::vector<uint8_t> tracker;
  // The message stays in the builder, without a copy to the stream.
  void write(const TensorMessage& from, Room*) {
    builder.Clear();
    builder.Map([&] {
      builder.UInt("num_tensors", from.tensors.size());
      builder.Int("rate_n", from.rate_n);
      builder.Int("rate_d", from.rate_d);
      builder.Int("format", from.format);
      for (size_t i = 0; i < from.tensors.size(); ++i) {
        const auto& tensor = from.tensors[i];
        builder.Vector(("tensor_" + std::to_string(i)).c_str(), [&] {
          builder.String("");
          builder.Int(tensor.type);
          builder.Vector(tensor.dimensions.data(), tensor.dimensions.size());
          builder.Blob(tensor.data.data(), tensor.data.size());
        });
      }
    });
    builder.Finish();
    seen += builder.GetSize();
  }
  void parse(std::span<const std::byte> bytes) {
    const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
    if (!flexbuffers::VerifyBuffer(data, bytes.size(), &tracker)) std::abort();
    const auto map = flexbuffers::GetRoot(data, bytes.size()).AsMap();
    for (size_t i = 0; i < map["num_tensors"].AsUInt32(); ++i) {
      const auto from = map[("tensor_" + std::to_string(i)).c_str()].AsVector();
      MessageTensor tensor;
      tensor.type = from[1].AsUInt32();
      const auto dimensions = from[2].AsTypedVector();
      for (size_t d = 0; d < dimensions.size(); ++d)
        tensor.dimensions[d] = dimensions[d].AsUInt32();
      const auto blob = from[3].AsBlob();
      tensor.data = std::as_bytes(std::span(blob.data(), blob.size()));
      use(tensor);
    }
  }
};

template <class Bare>
void compare(const char* library, uint32_t side, int repeats, int rounds) {
  const std::vector<std::byte> pixels(3 * side * side, std::byte{7});
  TensorMessage frame{30, 1, kStatic, {{}}}, parsed;
  frame.tensors[0].type = WEIR_UINT8;
  frame.tensors[0].dimensions = {3, side, side, 1};
  frame.tensors[0].data = pixels;
  typename Bare::Ours ours;
  Bare bare;
  Room room, read;
  const ReserveBytes reserve = [&](size_t bytes) { return room.reserve(bytes); };
  if (!ours.write(frame, [&](size_t bytes) { return read.reserve(bytes); })) std::abort();
  const auto often = [repeats](auto&& run) {
    return [run, repeats] {
      for (int i = 0; i < repeats; ++i) run();
    };
  };
  const auto costs =
      weir::bench::min({often([&] { bare.write(frame, &room); }),
                        often([&] { seen += ours.write(frame, reserve).has_value(); }),
                        often([&] { bare.parse(read.message()); }), often([&] {
                          if (!ours.parse(read.message(), &parsed)) std::abort();
                          for (const auto& tensor : parsed.tensors) use(tensor);
                        })},
                       rounds);
  const std::string size = std::to_string(pixels.size()) + " bytes";
  const auto report = [&](const char* what, const weir::bench::Cost& with,
                          const weir::bench::Cost& without) {
    char floor[64];
    std::snprintf(floor, sizeof floor, "%s, %.2f us", library, without.cpu / repeats * 1e6);
    weir::bench::report(std::string(Bare::Ours::kName) + ", " + what + " " + size + ": CPU", floor,
                        with.cpu / without.cpu, "x", 1.2);
  };
  report("writing", costs[1], costs[0]);
  report("parsing", costs[3], costs[2]);
}

}  // namespace

// Usage: message_cost ROUNDS
int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const int rounds = std::atoi(argv[1]);
  for (const auto& [side, repeats] : {std::pair{18u, 2000}, {224u, 200}}) {
    compare<BareProtobuf>("protoc's classes", side, repeats, rounds);
    compare<BareFlatbuf>("flatc's classes", side, repeats, rounds);
    compare<BareFlexbuf>("FlexBuffers", side, repeats, rounds);
  }
  return seen == 0;
}
