// FlatValue: a tree of tables, vectors and strings that tests write as a FlatBuffers file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

namespace weir::engine_test {

class FlatValue {
 public:
  FlatValue() = default;  // omitted from its table

  template <class T>
  static FlatValue scalar(T value) {
    static_assert(std::is_arithmetic_v<T>);
    FlatValue out(Kind::kScalar);
    out.raw_.assign(reinterpret_cast<const char*>(&value), sizeof value);
    return out;
  }
  template <class T>
  static FlatValue vector(const std::vector<T>& values) {
    FlatValue out(Kind::kVector);
    out.count_ = values.size();
    out.raw_.resize(values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(out.raw_.data(), values.data(), out.raw_.size());
    return out;
  }
  static FlatValue text(const std::string& text);
  // `fields`: values by field number.
  static FlatValue table(const std::map<uint32_t, FlatValue>& fields);
  static FlatValue tables(const std::vector<FlatValue>& tables);

  bool is_absent() const { return kind_ == Kind::kAbsent; }
  // The file with this root table; `mark` is its 4-letter identifier.
  std::vector<std::byte> file(const std::string& mark) const;

 private:
  enum class Kind { kAbsent, kScalar, kVector, kText, kTable, kTables };
  explicit FlatValue(Kind kind) : kind_(kind) {}
  // Appends a value that is not a scalar, parents before children; returns the position of its
  // first byte.
  size_t write(std::string* out) const;
  size_t write_table(std::string* out) const;

  Kind kind_ = Kind::kAbsent;
  std::string raw_;
  size_t count_ = 0;
  std::vector<FlatValue> children_;  // fields of a table, elements of a vector of tables
  std::vector<uint32_t> numbers_;    // field numbers, ascending
};

}  // namespace weir::engine_test
