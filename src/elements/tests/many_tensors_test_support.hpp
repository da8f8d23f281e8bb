// Frames of 1 to 20 tensors of ranks 1 to 16 with known values, static and flexible. Headers and
// packed memories are written byte by byte from docs/compatibility/types-and-caps.md 1.6,
// independently of the code under test.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <ostream>
#include <string>
#include <vector>

#include "weir/join.hpp"

namespace weir::test {

// Tensor i of a sweep has rank `first_rank` + i (from 16 back to 1); the types alternate.
struct Sweep {
  size_t count = 1, first_rank = 1;
  bool flexible = false;
};
inline std::ostream& operator<<(std::ostream& out, const Sweep& sweep) {
  return out << sweep.count << " tensors from rank " << sweep.first_rank
             << (sweep.flexible ? ", flexible" : ", static");
}
// 1 to 20 tensors, and one tensor of each rank.
inline std::vector<Sweep> sweep(bool with_flexible = true) {
  std::vector<Sweep> out;
  for (const bool flexible : {false, true}) {
    if (flexible && !with_flexible) continue;
    for (size_t rank = 1; rank <= 16; ++rank) out.push_back({1, rank, flexible});
    for (size_t count = 2; count <= 20; ++count) out.push_back({count, count, flexible});
  }
  return out;
}

struct Numbers {
  const char* type;
  uint32_t code;  // in headers
  size_t bytes;
  void (*write)(unsigned value, uint8_t* to);
};
template <class T>
void write_number(unsigned value, uint8_t* to) {
  const auto number = static_cast<T>(value);
  std::memcpy(to, &number, sizeof number);
}
inline const Numbers& get_numbers(size_t tensor) {
  static constexpr Numbers kNumbers[] = {
      {"uint8", 5, 1, write_number<uint8_t>},   {"int16", 2, 2, write_number<int16_t>},
      {"float32", 7, 4, write_number<float>},   {"int64", 8, 8, write_number<int64_t>},
      {"float64", 6, 8, write_number<double>},  {"uint32", 1, 4, write_number<uint32_t>},
      {"uint64", 9, 8, write_number<uint64_t>},
  };
  return kNumbers[tensor % std::size(kNumbers)];
}

// 3:2:2:1:1..., as many as the rank, and tensor + 2 along the last.
inline std::vector<uint32_t> make_dimensions(const Sweep& sweep, size_t tensor) {
  std::vector<uint32_t> out{3, 2, 2};
  out.resize((sweep.first_rank + tensor - 1) % 16 + 1, 1);
  out.back() = static_cast<uint32_t>(tensor + 2);
  return out;
}
inline std::string dimension_text(const std::vector<uint32_t>& dimensions) {
  return join(dimensions, ":", [](uint32_t d) { return std::to_string(d); });
}
inline size_t count_elements(const std::vector<uint32_t>& dimensions) {
  size_t out = 1;
  for (const uint32_t d : dimensions) out *= d;
  return out;
}
inline unsigned number_at(size_t tensor, size_t element) {
  return static_cast<unsigned>((tensor + element) % 128);
}

inline void append_word(std::vector<uint8_t>* out, uint64_t value, size_t bytes) {
  for (size_t i = 0; i < bytes; ++i) out->push_back(static_cast<uint8_t>(value >> (8 * i)));
}
inline void append_dimensions(std::vector<uint8_t>* out, const std::vector<uint32_t>& dimensions) {
  for (size_t d = 0; d < 16; ++d) append_word(out, d < dimensions.size() ? dimensions[d] : 0, 4);
}

inline std::vector<uint8_t> make_payload(const Sweep& sweep, size_t tensor) {
  const Numbers& numbers = get_numbers(tensor);
  std::vector<uint8_t> out(count_elements(make_dimensions(sweep, tensor)) * numbers.bytes);
  for (size_t i = 0; i * numbers.bytes < out.size(); ++i)
    numbers.write(number_at(tensor, i), out.data() + i * numbers.bytes);
  return out;
}
// docs/compatibility/types-and-caps.md 1.7.
inline std::vector<uint8_t> make_chunk(const Sweep& sweep, size_t tensor) {
  std::vector<uint8_t> out;
  append_word(&out, 0xfeedcced, 4);
  append_word(&out, 0xDE001000, 4);
  append_word(&out, get_numbers(tensor).code, 4);
  append_dimensions(&out, make_dimensions(sweep, tensor));
  append_word(&out, 0, 4);  // of a static tensor
  append_word(&out, 4, 4);  // media: a tensor
  out.resize(128);
  const auto payload = make_payload(sweep, tensor);
  out.insert(out.end(), payload.begin(), payload.end());
  return out;
}
inline std::vector<uint8_t> make_tensor(const Sweep& sweep, size_t tensor) {
  return sweep.flexible ? make_chunk(sweep, tensor) : make_payload(sweep, tensor);
}

// The memories of a frame of these tensors (docs/compatibility/types-and-caps.md 1.6 for more than
// 16).
inline std::vector<std::vector<uint8_t>> make_memories(const Sweep& sweep,
                                                       const std::vector<size_t>& tensors) {
  std::vector<std::vector<uint8_t>> all;
  for (const size_t tensor : tensors) all.push_back(make_tensor(sweep, tensor));
  if (all.size() <= 16) return all;
  std::vector<uint8_t> packed;
  append_word(&packed, 0xf00dc0de, 4);
  append_word(&packed, 0, 4);
  append_word(&packed, all.size() - 16, 8);
  append_word(&packed, all[15].size(), 8);
  for (size_t i = 16; i < all.size(); ++i) {
    append_word(&packed, 0, 8);
    append_word(&packed, get_numbers(tensors[i]).code, 4);
    append_dimensions(&packed, make_dimensions(sweep, tensors[i]));
    append_word(&packed, 0, 4);
  }
  packed.resize(19224);
  for (size_t i = 15; i < all.size(); ++i)
    packed.insert(packed.end(), all[i].begin(), all[i].end());
  all.resize(15);
  all.push_back(std::move(packed));
  return all;
}
// The indices from `from` up to, but not including, `to`.
inline std::vector<size_t> make_range(size_t from, size_t to) {
  std::vector<size_t> out;
  for (size_t i = from; i < to; ++i) out.push_back(i);
  return out;
}

inline std::string make_caps(const Sweep& sweep, const std::vector<size_t>& tensors) {
  if (sweep.flexible) return "other/tensors,format=flexible,framerate=30/1";
  const std::string dimensions = join(
      tensors, ",", [&](size_t tensor) { return dimension_text(make_dimensions(sweep, tensor)); });
  const std::string types =
      join(tensors, ",", [](size_t tensor) { return get_numbers(tensor).type; });
  return "other/tensors,format=static,num_tensors=" + std::to_string(tensors.size()) +
         ",dimensions=(string)\"" + dimensions + "\",types=(string)\"" + types +
         "\",framerate=30/1";
}

}  // namespace weir::test
