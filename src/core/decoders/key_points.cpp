// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/key_points.hpp"

#include "core/text/text.hpp"
#include "weir/label_file.hpp"

namespace weir::decoders {
namespace {

constexpr size_t kMaxNameLength = 15;  // bytes
constexpr size_t kMaxConnections = 7;

struct Line {
  std::string name;
  std::vector<size_t> connections;
};

// A connection is drawn once: that of the later key point to the earlier one repeats it.
KeyPoints from_lines(const std::vector<Line>& lines) {
  KeyPoints out;
  for (size_t i = 0; i < lines.size(); ++i) {
    out.names.push_back(lines[i].name);
    for (const size_t to : lines[i].connections)
      if (to >= i) out.bones.push_back({i, to});
  }
  return out;
}

class Reader {
 public:
  Reader(const std::string& option, const std::string& path)
      : file_(option + "=" + path), texts_(read_label_file(option, path)) {}

  KeyPoints read() {
    std::vector<Line> lines;
    for (const std::string& text : texts_) lines.push_back(read_line(text));
    return from_lines(lines);
  }

 private:
  Line read_line(const std::string& text) {
    ++number_;
    Line line;
    for (const std::string_view word : split(text, " \t")) {
      if (word.empty()) continue;
      if (line.name.empty())
        line.name = word;
      else
        line.connections.push_back(read_connection(word));
    }
    if (line.name.empty()) throw failure("has no name", "an empty line", "a name in each line");
    if (line.name.size() > kMaxNameLength)
      throw failure("has a name that is too long", line.name,
                    "names of at most " + std::to_string(kMaxNameLength) + " bytes",
                    line.name.substr(0, kMaxNameLength));
    if (line.connections.size() > kMaxConnections)
      throw failure("has too many connections",
                    line.name + " with " + std::to_string(line.connections.size()),
                    "at most " + std::to_string(kMaxConnections) +
                        "; the line of the key point with the lower index is enough");
    return line;
  }

  size_t read_connection(std::string_view word) const {
    const auto index = parse_unsigned(word);
    if (!index)
      throw failure("has a connection that is not a number", std::string(word),
                    "a name without blanks, then indices of key points, from 0", "nose 1 2");
    if (*index >= texts_.size())
      throw failure("has a connection to a key point that does not exist", std::string(word),
                    "an index from 0 to " + std::to_string(texts_.size() - 1) +
                        ", one line for each key point");
    return *index;
  }

  Failure failure(const std::string& what, const std::string& offered, std::string needed,
                  std::string fix = "") const {
    const std::string line = std::to_string(number_);
    if (fix.empty()) fix = "correct line " + line;
    return Failure({.code = Code::LABELS_INVALID,
                    .what = "line " + line + " of the key point file " + what,
                    .offered = offered + " (" + file_ + ")",
                    .needed = std::move(needed),
                    .fix = std::move(fix)});
  }

  std::string file_;
  std::vector<std::string> texts_;
  size_t number_ = 0;
};

}  // namespace

const KeyPoints& default_key_points() {
  static const KeyPoints body = from_lines({{"top", {1}},
                                            {"neck", {0, 2, 5, 8, 11}},
                                            {"r_shoulder", {1, 3}},
                                            {"r_elbow", {2, 4}},
                                            {"r_wrist", {3}},
                                            {"l_shoulder", {1, 6}},
                                            {"l_elbow", {5, 7}},
                                            {"l_wrist", {6}},
                                            {"r_hip", {1, 9}},
                                            {"r_knee", {8, 10}},
                                            {"r_ankle", {9}},
                                            {"l_hip", {1, 12}},
                                            {"l_knee", {11, 13}},
                                            {"l_ankle", {12}}});
  return body;
}

KeyPoints read_key_point_file(const std::string& option, const std::string& path) {
  return Reader(option, path).read();
}

}  // namespace weir::decoders
