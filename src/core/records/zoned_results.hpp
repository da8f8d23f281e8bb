// ZonedResults: reads the objects of a frame of results for a ZoneCounter, and writes the frame
// with what it found.
//
//   auto zoned = ZonedResults::make(roles, {});
//   zoned->read(tensors, &sightings);
//   counter.update(time, sightings);
//   for (const OutputTensor& tensor : zoned->write(tensors, counter)) append(tensor);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <span>
#include <string>
#include <vector>

#include "core/records/result_frame.hpp"
#include "core/tensor/result_roles.hpp"
#include "core/zone/zone_counter.hpp"

namespace weir::records {

struct ZonedSettings {
  uint32_t zones_per_object = 4;  // at most that many are named in the row of an object
  std::string source = "zones";   // of the tables of zones, in weir-source
};

// A tensor of the output: numbers, or the input's tensor `input` as it is.
struct OutputTensor {
  TensorSpec spec;
  std::vector<float> numbers{};
  int32_t input = -1;
  bool is_table = false;  // of zones
};

class ZonedResults {
 public:
  // SPEC_MISMATCH: no rows have boxes and tracks, or they have zones already. LIMIT_EXCEEDED.
  static Result<ZonedResults> make(const ResultRoles& roles, ZonedSettings settings);

  // The roles of the output. The tables of zones follow the tensors that have a role.
  const ResultRoles& roles() const noexcept { return roles_; }
  // The source of the classes of a group of sightings.
  const std::string& get_source(uint32_t group) const { return roles_[group].source; }

  // Errors: ResultReader::check(), FRAME_SIZE. Objects without a box, and rows that are not finite,
  // are not read.
  Status read(std::span<const ResultTensor> tensors, std::vector<zone::Sighting>* out);
  // After update() with these sightings. `unnamed` counts the zones that zones_per_object left out.
  std::vector<OutputTensor> write(std::span<const ResultTensor> tensors,
                                  const zone::ZoneCounter& counter, uint64_t* unnamed) const;

 private:
  OutputTensor widened(const ResultTensor& tensor, uint32_t index, const zone::ZoneCounter& counter,
                       size_t* next, uint64_t* unnamed) const;

  ZonedSettings settings_;
  size_t n_inputs_ = 0;  // tensors that have a role
  ResultRoles roles_;
  ResultReader reader_;
  std::vector<weir_result_columns> columns_;  // of each input tensor
  std::vector<bool> is_widened_;              // likewise
  // The place of each sighting, in order of tensors and rows.
  struct RowPlace {
    uint32_t tensor = 0, row = 0;
  };
  std::vector<RowPlace> rows_;
  ResultFrame frame_;
};

}  // namespace weir::records
