// Descriptors for Weir's own engines, decoders and converters. Most functions of a descriptor get
// no pointer to it, so each type has its own functions, by number.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <atomic>
#include <mutex>
#include <utility>

#include "weir/result.hpp"

namespace weir::compat {

// `Type` is a table of a module or of libweir; it stays until the process ends, as descriptors do.
template <class Descriptor, class Type>
class Slots {
 public:
  static constexpr size_t kMax = 64;
  using Table = std::array<Descriptor, kMax>;
  explicit Slots(const Table& table) : table_(table) {}
  Slots(const Slots&) = delete;
  Slots& operator=(const Slots&) = delete;

  // Returns the descriptor of `type`; `name_it(descriptor, number)` fills its data members, once.
  template <class NameIt>
  Result<const Descriptor*> of(const Type& type, NameIt name_it) {
    std::lock_guard lock(mutex_);
    for (size_t i = 0; i < count_; ++i)
      if (types_[i] == &type) return &table_[i];
    const size_t number = count_;
    if (number == kMax)
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "too many descriptors of this kind are in use",
                   .needed = "at most " + std::to_string(kMax)};
    types_[number] = &type;
    name_it(table_[number], number);
    ++count_;
    return &table_[number];
  }
  // Returns the type of a number from of().
  const Type& type(size_t number) const noexcept { return *types_[number].load(); }

 private:
  std::mutex mutex_;  // guards of()
  Table table_;
  std::array<std::atomic<const Type*>, kMax> types_{};
  size_t count_ = 0;
};

// Makes the table of make.operator()<0>() and so on; `make` is a lambda of the calling file. With a
// class template as parameter, GCC 12 takes those of one name in anonymous namespaces for the same,
// and the linker keeps one table for all files.
template <class Make, size_t... N>
auto slot_table(Make make, std::index_sequence<N...>) {
  return std::array{make.template operator()<N>()...};
}

}  // namespace weir::compat
