// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/record_writer.hpp"

#include "core/records/record_text.hpp"
#include "core/records/run_lengths.hpp"
#include "weir/label_file.hpp"

namespace weir::records {

std::string_view Labels::of(uint32_t source, int32_t index, std::string* number) const {
  if (source < of_source_.size() && index >= 0 &&
      static_cast<size_t>(index) < of_source_[source].size())
    return of_source_[source][static_cast<size_t>(index)];
  *number = std::to_string(index);
  return *number;
}

Labels read_labels(const std::string& option, const std::string& paths) {
  std::vector<std::vector<std::string>> out;
  for (size_t begin = 0; !paths.empty() && begin <= paths.size();) {
    const size_t end = std::min(paths.find(';', begin), paths.size());
    const std::string path = paths.substr(begin, end - begin);
    out.push_back(path.empty() ? std::vector<std::string>() : read_label_file(option, path));
    begin = end + 1;
  }
  return Labels(std::move(out));
}

std::vector<std::vector<std::string>> labels_of_sources(const LabelsBySource& labels,
                                                        const std::vector<std::string>& sources) {
  std::vector<std::vector<std::string>> out;
  bool is_known = false;
  for (const auto& source : sources) {
    const auto found = labels.find(source);
    is_known |= found != labels.end();
    out.push_back(found != labels.end() ? found->second : std::vector<std::string>());
  }
  return is_known ? out : std::vector<std::vector<std::string>>();
}

const ResultObject* with_box(const ResultFrame& frame, const ResultObject& object) noexcept {
  if (object.has_box) return &object;
  if (object.parent < 0) return nullptr;
  const ResultObject& parent = frame.objects[static_cast<size_t>(object.parent)];
  return parent.has_box ? &parent : nullptr;
}

RowKind get_kind(const ResultReader& reader, const ResultObject& object) noexcept {
  return reader.groups()[object.group].kind();
}

void append_mask(const std::vector<uint32_t>& runs, uint32_t width, uint32_t height,
                 std::string* out) {
  *out += "{\"size\":[";
  append_number(int64_t{height}, out);
  *out += ',';
  append_number(int64_t{width}, out);
  *out += "],\"counts\":";
  append_json_string(to_string(runs), out);
  *out += '}';
}

}  // namespace weir::records
