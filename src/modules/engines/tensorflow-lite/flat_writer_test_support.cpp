// Writes FlatBuffers; layout: the FlatBuffers internals page. Offsets point forward, relative to
// themselves.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/flat_writer_test_support.hpp"

namespace weir::engine_test {
namespace {

template <class T>
void put(std::string* out, size_t at, T value) {
  std::memcpy(out->data() + at, &value, sizeof value);
}
template <class T>
size_t append(std::string* out, T value) {
  const size_t at = out->size();
  out->resize(at + sizeof value);
  put(out, at, value);
  return at;
}
// Adds zeros until the position `ahead` bytes after the end is a multiple of `step`.
void align(std::string* out, size_t step, size_t ahead = 0) {
  while ((out->size() + ahead) % step != 0) *out += '\0';
}

}  // namespace

FlatValue FlatValue::text(const std::string& text) {
  FlatValue out(Kind::kText);
  out.raw_ = text;
  out.count_ = text.size();
  return out;
}

FlatValue FlatValue::table(const std::map<uint32_t, FlatValue>& fields) {
  FlatValue out(Kind::kTable);
  for (const auto& [number, value] : fields) {
    if (value.is_absent()) continue;
    out.numbers_.push_back(number);
    out.children_.push_back(value);
  }
  return out;
}

FlatValue FlatValue::tables(const std::vector<FlatValue>& tables) {
  FlatValue out(Kind::kTables);
  out.children_ = tables;
  return out;
}

std::vector<std::byte> FlatValue::file(const std::string& mark) const {
  std::string out(4, '\0');
  out += mark;
  put(&out, 0, static_cast<uint32_t>(write(&out)));
  std::vector<std::byte> bytes(out.size());
  std::memcpy(bytes.data(), out.data(), out.size());
  return bytes;
}

size_t FlatValue::write(std::string* out) const {
  if (kind_ == Kind::kTable) return write_table(out);
  align(out, 16, 4);  // alignment required for a model's buffers
  const size_t at =
      append(out, static_cast<uint32_t>(kind_ == Kind::kTables ? children_.size() : count_));
  if (kind_ != Kind::kTables) {
    *out += raw_;
    if (kind_ == Kind::kText) *out += '\0';
    return at;
  }
  const size_t first = out->size();
  out->resize(first + 4 * children_.size());
  for (size_t i = 0; i < children_.size(); ++i) {
    const size_t place = first + 4 * i;
    put(out, place, static_cast<uint32_t>(children_[i].write(out) - place));
  }
  return at;
}

size_t FlatValue::write_table(std::string* out) const {
  const uint32_t entries = numbers_.empty() ? 0 : numbers_.back() + 1;
  align(out, 4);
  const size_t vtable = out->size();
  out->resize(vtable + 4 + 2 * size_t{entries});
  align(out, 8);
  const size_t at = append(out, int32_t{0});
  put(out, at, static_cast<int32_t>(at - vtable));
  std::vector<size_t> places;
  for (size_t i = 0; i < children_.size(); ++i) {
    const bool scalar = children_[i].kind_ == Kind::kScalar;
    align(out, scalar ? children_[i].raw_.size() : 4);
    places.push_back(out->size());
    put(out, vtable + 4 + 2 * size_t{numbers_[i]}, static_cast<uint16_t>(out->size() - at));
    *out += scalar ? children_[i].raw_ : std::string(4, '\0');
  }
  put(out, vtable, static_cast<uint16_t>(4 + 2 * entries));
  put(out, vtable + 2, static_cast<uint16_t>(out->size() - at));
  for (size_t i = 0; i < children_.size(); ++i) {
    if (children_[i].kind_ == Kind::kScalar) continue;
    const size_t target = children_[i].write(out);
    put(out, places[i], static_cast<uint32_t>(target - places[i]));
  }
  return at;
}

}  // namespace weir::engine_test
