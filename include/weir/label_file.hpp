// Reads label files: UTF-8 text with one label per line, the first for class 0.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "weir/module.hpp"
#include "weir/printable_text.hpp"

namespace weir {

// Returns true for UTF-8 without zero bytes.
constexpr bool is_text(std::string_view text) noexcept {
  while (!text.empty()) {
    const size_t length = utf8_sequence(text);
    if (length == 0 || text[0] == '\0') return false;
    text.remove_prefix(length);
  }
  return true;
}

inline constexpr size_t kMaxLabelBytes = size_t{16} << 20;

// Reads the labels of the file at `path`, the value of `option` ("option1"). Keeps empty lines;
// removes carriage returns at line ends and a byte order mark. Throws Failure: FILE_NOT_FOUND when
// the file cannot be read, LABELS_INVALID when it is empty, larger than 16 MiB or not UTF-8 text.
inline std::vector<std::string> read_label_file(const std::string& option,
                                                const std::string& path) {
  const auto failure = [&](Code code, std::string what, std::string needed, std::string fix) {
    return Failure(
        {code, std::move(what), option + "=" + path, std::move(needed), "", std::move(fix)});
  };
  std::error_code reason;
  const auto kind = std::filesystem::status(path, reason).type();
  errno = 0;
  std::ifstream file;
  // Opening a FIFO would wait for its writer.
  if (kind != std::filesystem::file_type::fifo) file.open(path, std::ios::binary);
  const int open_error = errno;
  if (!file.is_open() || kind != std::filesystem::file_type::regular) {
    const std::string text = !file.is_open() && open_error != 0
                                 ? std::generic_category().message(open_error)
                             : kind == std::filesystem::file_type::directory ? "Is a directory"
                             : reason                                        ? reason.message()
                                                                             : "not a regular file";
    throw failure(Code::FILE_NOT_FOUND, "the label file cannot be read: " + text,
                  "a text file with one label a line", option + "=/path/to/labels.txt");
  }
  std::string text;
  for (char piece[4096]; file && text.size() <= kMaxLabelBytes;) {
    file.read(piece, sizeof piece);
    text.append(piece, static_cast<size_t>(file.gcount()));
  }
  if (text.size() > kMaxLabelBytes)
    throw failure(Code::LABELS_INVALID, "the label file is too large", "at most 16 MiB",
                  option + "=/path/to/labels.txt");
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (text.ends_with('\n')) text.pop_back();
  if (text.empty())
    throw failure(Code::LABELS_INVALID, "the label file is empty", "one label a line",
                  option + "=/path/to/labels.txt");
  std::vector<std::string> labels;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    labels.push_back(text.substr(begin, end - begin));
    if (labels.back().ends_with('\r')) labels.back().pop_back();
    if (!is_text(labels.back()))
      throw failure(Code::LABELS_INVALID,
                    "line " + std::to_string(labels.size()) + " of the label file is not UTF-8",
                    "labels in UTF-8",
                    "iconv -f ISO-8859-1 -t UTF-8 " + path + " > labels-utf8.txt");
    begin = end + 1;
  }
  return labels;
}

}  // namespace weir
