// `weir new filter|engine|decoder|converter`: creates a folder with one that builds, runs and has a
// test.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "commands.hpp"
#include "core/text/text.hpp"
#include "embedded_files.hpp"
#include "report.hpp"
#include "weir/join.hpp"
#include "weir/result.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxModuleName = 64;
constexpr std::string_view kFilter = "filter";
constexpr const char* kLanguages[] = {"c", "c++", "lua", "python"};

// "weir new filter --language c++", the command without a name.
std::string make_command(const NewModuleOptions& options, const std::string& language) {
  return "weir new " + options.kind + (options.kind == kFilter ? " --language " + language : "");
}

Status check_language(const NewModuleOptions& options) {
  const std::vector<std::string> known(std::begin(kLanguages), std::end(kLanguages));
  const std::string& language = options.language;
  if (options.kind != kFilter || std::find(known.begin(), known.end(), language) != known.end())
    return ok();
  const std::string close = language == "cpp" ? "c++" : nearest(language, known);
  return Error{.code = Code::OPTION_VALUE,
               .what = "there is no template for this language",
               .offered = "--language " + language,
               .needed = "one of: " + join(known, ", "),
               .difference = close.empty() ? "" : "did you mean " + close + "?",
               .fix = make_command(options, close.empty() ? "c++" : close) + " NAME"};
}

// The name is used in pipelines, as the folder and in code: letters, digits, - and _.
Status check_name(const NewModuleOptions& options) {
  const std::string& name = options.name;
  const auto plain = [](unsigned char c) {
    return c < 128 && (std::islower(c) || std::isdigit(c) || c == '-' || c == '_');
  };
  const bool good = !name.empty() && name.size() <= kMaxModuleName && name[0] >= 'a' &&
                    name[0] <= 'z' && std::all_of(name.begin(), name.end(), plain) &&
                    name != "auto" && name != "any";
  if (good) return ok();
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "this cannot be the name of a new " + options.kind,
      .offered = '"' + name + '"',
      .needed =
          "a lower-case letter, then lower-case letters, digits, - or _, at most 64 characters;"
          " not auto or any",
      .fix = make_command(options, options.language) + " brightness"};
}

// "brightness-of-sky" -> "BrightnessOfSky".
std::string class_name(const std::string& name) {
  std::string out;
  bool begins = true;
  for (const char c : name) {
    if (c == '-' || c == '_') {
      begins = true;
      continue;
    }
    out += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    begins = false;
  }
  return out;
}

void replace_all(std::string* text, std::string_view from, const std::string& to) {
  for (size_t at = text->find(from); at != std::string::npos; at = text->find(from, at + to.size()))
    text->replace(at, from.size(), to);
}

Error not_written(const fs::path& path, const std::string& why, const std::string& fix) {
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "a file of the new folder cannot be written",
               .offered = path.string() + ": " + why,
               .needed = "a writable folder",
               .fix = fix};
}

Status write(const fs::path& path, const EmbeddedFile& part, const NewModuleOptions& options) {
  std::string text(part.text);
  replace_all(&text, "KIND", options.kind);  // in files that all kinds of modules share
  const std::string template_name = "my-" + options.kind;
  replace_all(&text, template_name, options.name);
  replace_all(&text, class_name(template_name), class_name(options.name));
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  return file ? ok() : Status(not_written(path, "it cannot be written", ""));
}

Result<std::vector<std::string>> write_folder(const NewModuleOptions& options) {
  const fs::path folder = options.name;
  std::error_code failed;
  if (!fs::create_directory(folder, failed)) {
    if (failed) return not_written(folder, failed.message(), "");
    return Error{.code = Code::FILE_NOT_WRITTEN,
                 .what = "a file or folder with this name already exists",
                 .offered = folder.string(),
                 .needed = "an unused name in this folder",
                 .fix = make_command(options, options.language) + " " + options.name + "-2"};
  }
  std::vector<std::string> files;
  const std::string& group = options.kind == kFilter ? options.language : options.kind;
  for (const auto& part : module_templates()) {
    if (part.group != group) continue;
    const fs::path path = folder / part.name;
    if (auto status = write(path, part, options); !status) {
      fs::remove_all(folder, failed);
      return status.error();
    }
    files.push_back(path.string());
  }
  return files;
}

}  // namespace

int new_module(const NewModuleOptions& options) {
  for (const Status& status : {check_language(options), check_name(options)})
    if (!status) return report(status.error(), false);
  const auto files = write_folder(options);
  if (!files) return report(files.error(), false);
  for (const auto& file : *files) std::printf("%s\n", file.c_str());
  std::printf("\ncd %s && make test\n", options.name.c_str());
  return kExitGood;
}

}  // namespace weir::app
