// Reads sizes and switches.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/option_text.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/text/text.hpp"

namespace weir::decoders {
namespace {

constexpr uint64_t kLongestSide = 32767;   // pixels
constexpr size_t kLongestFile = 16 << 20;  // bytes

}  // namespace

FrameSize read_size(const Options& options, const char* option, const char* meaning) {
  const std::string text(options.get(option).value_or(""));
  const auto failure = [&](Code code, const char* what) {
    return Failure({.code = code,
                    .what = std::string(option) + " " + what,
                    .offered = text.empty() ? "no " + std::string(option) : option + ("=" + text),
                    .needed = std::string(meaning) + " as WIDTH:HEIGHT, each from 1 to " +
                              std::to_string(kLongestSide),
                    .fix = std::string(option) + "=640:480"});
  };
  if (text.empty()) throw failure(Code::OPTION_VALUE, "is required");
  const auto parts = split(text, ":");
  if (parts.size() != 2) throw failure(Code::OPTION_SYNTAX, "is not a size");
  const auto width = parse_unsigned(strip(parts[0])), height = parse_unsigned(strip(parts[1]));
  if (!width || !height) throw failure(Code::OPTION_SYNTAX, "is not a size");
  const auto fits = [](uint64_t side) { return side > 0 && side <= kLongestSide; };
  if (!fits(*width) || !fits(*height))
    throw failure(Code::OPTION_VALUE, "is a size that cannot be used");
  return {static_cast<uint32_t>(*width), static_cast<uint32_t>(*height)};
}

bool read_switch(const Options& options, const char* option) {
  const std::string_view text = strip(options.get(option).value_or(""));
  if (text.empty() || text == "0") return false;
  if (text == "1") return true;
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = std::string(option) + " is neither on nor off",
                 .offered = option + ("=" + std::string(text)),
                 .needed = "0 for off or 1 for on",
                 .fix = std::string(option) + "=1"});
}

std::string read_text_file(const std::string& option, const std::string& path) {
  const auto failure = [&](const std::string& reason) {
    return Failure({.code = Code::FILE_NOT_FOUND,
                    .what = "the file of " + option + " cannot be read: " + reason,
                    .offered = path.empty() ? "an empty path" : path,
                    .needed = "a readable text file of at most 16 MiB",
                    .fix = "ls -l " + path});
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  if (!file) throw failure(std::strerror(errno));
  std::string text;
  char block[4096];
  while (const size_t read = std::fread(block, 1, sizeof block, file.get())) {
    text.append(block, read);
    if (text.size() > kLongestFile) throw failure("it is too long");
  }
  if (std::ferror(file.get())) throw failure(std::strerror(errno));
  return text;
}

}  // namespace weir::decoders
