// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/mot_truth.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/config/ini.hpp"
#include "core/evaluate/similarity.hpp"
#include "core/evaluate/track_indices.hpp"
#include "core/text/text.hpp"
#include "core/track/assignment.hpp"

namespace weir::evaluate {
namespace {

constexpr uint32_t kMaxFrames = 1'000'000;

Error invalid(const std::string& path, std::string what, const std::string& offered,
              std::string needed, std::string fix) {
  return {.code = Code::LABELS_INVALID,
          .what = std::move(what),
          .offered = path + ": " + offered,
          .needed = std::move(needed),
          .fix = std::move(fix)};
}

struct Line {
  std::vector<double> numbers;
  size_t number = 0;  // counts from 1
  std::string text;
};

bool is_distractor(double class_number) {
  constexpr double kDistractors[] = {2, 7, 8, 12};
  return std::find(std::begin(kDistractors), std::end(kDistractors), class_number) !=
         std::end(kDistractors);
}

class TruthReader {
 public:
  TruthReader(const std::string& path, const SequenceInfo& info)
      : path_(path), info_(info), frames_(info.frames), seen_(info.frames) {}

  // The fault of a line, if it has one.
  std::optional<Error> add(const Line& line) {
    const auto fault = [&](std::string what, std::string needed, std::string fix) {
      return invalid(path_, std::move(what),
                     "line " + std::to_string(line.number) + ": " + line.text, std::move(needed),
                     std::move(fix));
    };
    const auto& n = line.numbers;
    if (n.size() < 6)
      return fault("a line of the truth cannot be read",
                   "frame,id,x,y,width,height,flag,class,visibility: finite numbers",
                   "correct the line, or delete it");
    const double frame = n[0], track = n[1];
    if (frame != std::floor(frame) || frame < 1 || frame > info_.frames)
      return fault("a line refers to a frame that the sequence does not have",
                   "a frame from 1 to " + std::to_string(info_.frames),
                   "correct seqLength of seqinfo.ini, or the line");
    constexpr double kMaxTrack = 1e15;
    if (track != std::floor(track) || std::abs(track) > kMaxTrack)
      return fault("the number of a track is not a whole number", "a whole number",
                   "correct the line");
    const Rectangle box{n[2] - 1, n[3] - 1, n[4], n[5]};  // pixels of the files count from 1
    if (!(box.width > 0 && box.height > 0))
      return fault("a box has no area", "a width and height above 0",
                   "correct the line, or delete it");
    const double right = box.x + box.width, bottom = box.y + box.height;
    if (right <= 0 || bottom <= 0 || box.x >= info_.width || box.y >= info_.height)
      return fault("a box is outside of its picture",
                   "a box that overlaps the picture of " + std::to_string(info_.width) + " x " +
                       std::to_string(info_.height) + " pixels",
                   "correct the line, or delete it");
    const auto index = static_cast<size_t>(frame) - 1;
    if (!seen_[index].insert(static_cast<int64_t>(track)).second)
      return fault("a track has two boxes in the same frame", "one box of a track in a frame",
                   "delete one of the lines, or correct its id");
    const bool is_counted = n.size() < 7 || n[6] != 0;
    TruthTracks& out = frames_[index];
    const TrackedBox tracked{static_cast<int64_t>(track), box};
    if (is_counted)
      out.counted.push_back(tracked);
    else if (n.size() > 7 && is_distractor(n[7]))
      out.neutral.push_back(tracked);
    return std::nullopt;
  }

  std::vector<TruthTracks> finish() { return std::move(frames_); }

 private:
  const std::string& path_;
  const SequenceInfo& info_;
  std::vector<TruthTracks> frames_;
  std::vector<std::set<int64_t>> seen_;
};

// The numbers of a line; none where one of them is no number.
std::vector<double> parse_numbers(std::string_view text) {
  std::vector<double> out;
  for (const auto part : split(text, ",")) {
    const auto number = parse_double(strip(part));
    if (!number) return {};
    out.push_back(*number);
  }
  return out;
}

// The entries of seqinfo.ini.
class SequenceValues {
 public:
  SequenceValues(const std::string& path, const config::Ini& ini) : path_(path), ini_(ini) {}

  std::string text(std::string_view key) const {
    for (const auto& entry : ini_.entries)
      if (equal_ignoring_case(entry.key, key)) return entry.value;
    return "";
  }
  Result<uint32_t> number(const std::string& key, uint32_t max) const {
    const auto parsed = parse_unsigned(text(key));
    if (parsed && *parsed > 0 && *parsed <= max) return static_cast<uint32_t>(*parsed);
    return invalid(path_, "the sequence has no valid " + key, key + "=" + text(key),
                   "a whole number from 1 to " + std::to_string(max),
                   key + "=600 in the group [Sequence]");
  }
  Result<double> frame_rate() const {
    const auto rate = parse_double(text("frameRate"));
    if (rate && *rate > 0 && *rate <= 10000) return *rate;
    return invalid(path_, "the sequence has no valid frameRate", "frameRate=" + text("frameRate"),
                   "frames per second, above 0", "frameRate=30 in the group [Sequence]");
  }

 private:
  const std::string& path_;
  const config::Ini& ini_;
};

}  // namespace

Result<SequenceInfo> parse_sequence_info(const std::string& path, std::string_view text) {
  const config::Ini ini = config::parse_ini(text, path);
  if (!ini.faults.empty()) return ini.faults.front();
  const SequenceValues values(path, ini);
  SequenceInfo out;
  out.name = values.text("name");
  if (const auto folder = values.text("imDir"); !folder.empty()) out.folder = folder;
  if (const auto extension = values.text("imExt"); !extension.empty()) out.extension = extension;
  const auto frames = values.number("seqLength", kMaxFrames);
  if (!frames) return frames.error();
  const auto width = values.number("imWidth", INT16_MAX);
  if (!width) return width.error();
  const auto height = values.number("imHeight", INT16_MAX);
  if (!height) return height.error();
  const auto rate = values.frame_rate();
  if (!rate) return rate.error();
  out.frames = *frames;
  out.width = *width;
  out.height = *height;
  out.frame_rate = *rate;
  return out;
}

Result<std::vector<TruthTracks>> parse_mot_truth(const std::string& path, std::string_view text,
                                                 const SequenceInfo& info) {
  TruthReader reader(path, info);
  size_t number = 0;
  for (const auto line : split(text, "\n")) {
    ++number;
    const auto stripped = strip(line);
    if (stripped.empty()) continue;
    if (auto fault =
            reader.add({parse_numbers(stripped), number, std::string(stripped.substr(0, 80))}))
      return *std::move(fault);
  }
  return reader.finish();
}

TrackedFrame without_neutral(const TruthTracks& truth, std::vector<TrackedBox> found) {
  TrackedFrame out{truth.counted, {}};
  std::vector<TrackedBox> all = truth.counted;
  all.insert(all.end(), truth.neutral.begin(), truth.neutral.end());
  track::Matrix overlaps(all.size(), found.size());
  for (size_t t = 0; t < all.size(); ++t)
    for (size_t f = 0; f < found.size(); ++f) {
      const double value = overlap(all[t].box, found[f].box);
      overlaps.at(t, f) = value >= kMinOverlap ? value : 0;
    }
  std::vector<bool> is_neutral(found.size(), false);
  const auto matches = track::best_assignment(overlaps);
  for (size_t t = truth.counted.size(); t < all.size(); ++t)
    if (matches[t] && overlaps.at(t, *matches[t]) > 0) is_neutral[*matches[t]] = true;
  for (size_t f = 0; f < found.size(); ++f)
    if (!is_neutral[f]) out.found.push_back(found[f]);
  return out;
}

}  // namespace weir::evaluate
