// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/protocol/oip_contents.hpp"

#include <cstring>

#include "net/protocol/oip_types.hpp"
#include "weir/module.hpp"

namespace weir::net {
namespace {

constexpr size_t kMaxRanges = 4096;

// Adds the extents of a field `shape`, packed or not.
bool read_shape(const Chunks& chunks, const Field& field, std::vector<int64_t>* shape) {
  if (field.type == WireType::Varint) {
    shape->push_back(static_cast<int64_t>(field.value));
    return shape->size() <= WEIR_RANK_LIMIT;
  }
  if (field.type != WireType::Bytes) return false;
  for (Cursor cursor(chunks, field.range); !cursor.at_end();) {
    const auto extent = cursor.varint();
    if (!extent || shape->size() == WEIR_RANK_LIMIT) return false;
    shape->push_back(static_cast<int64_t>(*extent));
  }
  return true;
}

// The whole numbers of a type, whose field of the contents may have more of them.
struct NumberRange {
  int64_t min, max;
};

NumberRange get_range(const OipType& type) {
  const auto bits = static_cast<uint32_t>(element_bytes(type.type) * 8);
  if (type.content_field == 1) return NumberRange{0, 1};
  if (type.content_field == 2) return NumberRange{-(1LL << (bits - 1)), (1LL << (bits - 1)) - 1};
  if (type.content_field == 4) return NumberRange{0, (1LL << bits) - 1};
  return {INT64_MIN, INT64_MAX};
}

// Writes numbers one after the other into memory of a fixed size.
class NumberWriter {
 public:
  NumberWriter(const OipType& type, std::span<std::byte> to)
      : bytes_(element_bytes(type.type)), range_(get_range(type)), to_(to) {}
  bool put(uint64_t value) {
    if (used_ + bytes_ > to_.size()) return false;
    const auto number = static_cast<int64_t>(value);
    if (number < range_.min || number > range_.max) {
      beyond_ = std::to_string(number);
      return false;
    }
    std::memcpy(to_.data() + used_, &value, bytes_);  // little-endian: the low bytes
    used_ += bytes_;
    return true;
  }
  bool full() const noexcept { return used_ == to_.size(); }
  // The number that the type does not have; "" while there was none.
  const std::string& beyond() const noexcept { return beyond_; }
  std::string numbers() const {
    return std::to_string(range_.min) + " to " + std::to_string(range_.max);
  }

 private:
  const size_t bytes_;
  const NumberRange range_;
  std::span<std::byte> to_;
  size_t used_ = 0;
  std::string beyond_;
};

// Reads one field of InferTensorContents: one number, or several packed.
bool read_numbers(const Chunks& chunks, const Field& field, size_t fixed_bytes, NumberWriter* to) {
  if (field.type != WireType::Bytes) {
    const bool fits = field.type == (fixed_bytes == 4   ? WireType::Fixed32
                                     : fixed_bytes == 8 ? WireType::Fixed64
                                                        : WireType::Varint);
    return fits && to->put(field.value);
  }
  for (Cursor cursor(chunks, field.range); !cursor.at_end();) {
    const auto value = fixed_bytes ? cursor.fixed(fixed_bytes) : cursor.varint();
    if (!value || !to->put(*value)) return false;
  }
  return true;
}

Status read_typed(const Chunks& chunks, const InferTensor& tensor, const OipType& type,
                  std::span<std::byte> to, Sender sender) {
  const size_t fixed_bytes = type.type == WEIR_FLOAT32 ? 4 : type.type == WEIR_FLOAT64 ? 8 : 0;
  NumberWriter writer(type, to);
  bool fits = type.content_field != 0;
  for (const Range range : tensor.contents) {
    FieldReader reader(chunks, range);
    for (Field field; fits && reader.next(&field);)
      if (field.number == type.content_field)
        fits = read_numbers(chunks, field, fixed_bytes, &writer);
    if (reader.failed()) return damaged_message(sender, "InferTensorContents");
  }
  if (fits && writer.full()) return ok();
  if (!writer.beyond().empty())
    return bad_message(sender, "the number " + writer.beyond() + " in " + describe(tensor),
                       "numbers from " + writer.numbers());
  return bad_message(sender,
                     "a wrong number of elements in the typed contents of " + describe(tensor),
                     std::to_string(to.size()) + " bytes of elements");
}

}  // namespace

Error bad_message(Sender sender, std::string offered, std::string needed) {
  const bool server = sender == Sender::Server;
  return {.code = Code::PEER_MESSAGE_INVALID,
          .what = server ? "a server sent a message that cannot be used"
                         : "a client sent a request that cannot be used",
          .offered = std::move(offered),
          .needed = std::move(needed),
          .fix = server ? "look at the server's log; another program may listen at this address"
                        : "compare the request with the answer to ModelMetadata"};
}

Error damaged_message(Sender sender, const char* message) {
  return bad_message(sender, std::string("a damaged ") + message, "a message of the protocol");
}

std::string describe(const TensorText& tensor) {
  std::string out = tensor.name + " " + tensor.datatype + " [";
  for (const int64_t extent : tensor.shape)
    out += (out.back() == '[' ? "" : ",") + std::to_string(extent);
  return out + "]";
}

bool read_tensor(const Chunks& chunks, Range range, TensorText* out, std::vector<Range>* contents) {
  FieldReader reader(chunks, range);
  for (Field field; reader.next(&field);) {
    if (field.number == 1) out->name = reader.text(field, kMaxNameBytes);
    if (field.number == 2) out->datatype = reader.text(field, kMaxNameBytes);
    if (field.number == 3 && !read_shape(chunks, field, &out->shape)) return false;
    if (field.number == 5 && contents) {
      if (field.type != WireType::Bytes || contents->size() == kMaxRanges) return false;
      contents->push_back(field.range);
    }
  }
  return !reader.failed();
}

bool read_tensor_field(const Chunks& chunks, const Field& field, uint32_t raw_field,
                       std::vector<InferTensor>* tensors, std::vector<Range>* raw) {
  constexpr uint32_t kTensors = 5;
  if (field.number != kTensors && field.number != raw_field) return true;
  const size_t count = field.number == kTensors ? tensors->size() : raw->size();
  if (field.type != WireType::Bytes || count == WEIR_TENSOR_LIMIT) return false;
  if (field.number == kTensors) {
    auto& tensor = tensors->emplace_back();
    return read_tensor(chunks, field.range, &tensor, &tensor.contents);
  }
  raw->push_back(field.range);
  return true;
}

Status set_raw(const std::vector<Range>& raw, Sender sender, std::vector<InferTensor>* tensors) {
  const bool server = sender == Sender::Server;
  if (!raw.empty() && raw.size() != tensors->size())
    return bad_message(
        sender,
        std::to_string(raw.size()) + " raw contents for " + std::to_string(tensors->size()) +
            (server ? " outputs" : " inputs"),
        server ? "one for each output" : "one for each input, or contents in each input");
  for (size_t i = 0; i < raw.size(); ++i) (*tensors)[i].raw = raw[i];
  return ok();
}

Status read_elements(const Chunks& chunks, const InferTensor& tensor, std::span<std::byte> to,
                     Sender sender) {
  const auto* type = oip_type(tensor.datatype);
  if (!type) return bad_message(sender, describe(tensor), "a type that tensor streams support");
  const auto& raw = tensor.raw;
  if (!raw) return read_typed(chunks, tensor, *type, to, sender);
  if (raw->size() != to.size())
    return bad_message(sender, std::to_string(raw->size()) + " bytes for " + describe(tensor),
                       std::to_string(to.size()) + " bytes");
  chunks.copy(*raw, to.data());
  return ok();
}

Result<Range> only_element(const Chunks& chunks, const InferTensor& tensor, Sender sender) {
  const auto other = [&] {
    return bad_message(sender, "not exactly one BYTES element in " + describe(tensor),
                       "one element");
  };
  if (const auto& raw = tensor.raw) {
    const auto length = Cursor(chunks, *raw).fixed(4);
    if (!length || *length != raw->size() - 4) return other();
    return Range{raw->begin + 4, raw->end};
  }
  std::vector<Range> found;
  for (const Range range : tensor.contents) {
    FieldReader reader(chunks, range);
    for (Field field; reader.next(&field);)
      if (field.number == 8 && field.type == WireType::Bytes && found.size() < 2)
        found.push_back(field.range);
    if (reader.failed()) return damaged_message(sender, "InferTensorContents");
  }
  if (found.size() != 1) return other();
  return found.front();
}

std::string encode_description(std::string_view name, std::string_view datatype,
                               std::span<const int64_t> shape) {
  std::string extents, out;
  for (const int64_t extent : shape) put_varint(&extents, static_cast<uint64_t>(extent));
  put_text(&out, 1, name);
  put_text(&out, 2, datatype);
  put_text(&out, 3, extents);
  return out;
}

void put_raw_contents(Pieces* to, uint32_t field, std::span<const RequestTensor> tensors) {
  for (const auto& tensor : tensors) {
    const bool element = tensor.datatype == "BYTES";  // its length comes first
    std::string head;
    put_bytes_header(&head, field, tensor.data.size() + (element ? 4 : 0));
    for (int shift = 0; element && shift < 32; shift += 8)
      head.push_back(static_cast<char>(tensor.data.size() >> shift));
    to->push_back({std::move(head), {}});
    to->push_back({"", tensor.data});
  }
}

}  // namespace weir::net
