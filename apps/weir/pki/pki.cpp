// `weir pki`: a certificate authority in a folder, and certificates of it for servers and clients.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "commands.hpp"
#include "core/text/shell_quote.hpp"
#include "pki/certificates.hpp"
#include "report.hpp"
#include "weir/join.hpp"
#include "weir/result.hpp"

namespace weir::app {
namespace {

namespace fs = std::filesystem;

struct NewFile {
  std::filesystem::path path;
  std::string text;
  mode_t mode;  // exactly, whatever the umask is
};

Error not_written(const fs::path& path, int error) {
  if (error == EEXIST)
    return Error{
        .code = Code::FILE_NOT_WRITTEN,
        .what = "a file with this name already exists and is not replaced",
        .offered = path.string(),
        .needed = "a name that is not in use",
        .fix = "mv " + shell_word(path.string()) + " " + shell_word(path.string() + ".old")};
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "a file cannot be written: " + std::generic_category().message(error),
               .offered = path.string(),
               .needed = "a folder that you may write to",
               .fix = "choose another folder, or correct the permissions of this one"};
}

// Writes a file of any name in the folder of `file`. 0, or errno.
int write_temporary(const NewFile& file, std::string* name) {
  const int descriptor = mkostemp(name->data(), O_CLOEXEC);
  if (descriptor < 0) return errno;
  int error = fchmod(descriptor, file.mode) == 0 ? 0 : errno;
  for (size_t done = 0; error == 0 && done < file.text.size();) {
    const ssize_t count = ::write(descriptor, file.text.data() + done, file.text.size() - done);
    if (count >= 0)
      done += static_cast<size_t>(count);
    else if (errno != EINTR)
      error = errno;
  }
  if (error == 0 && fsync(descriptor) != 0) error = errno;
  close(descriptor);
  return error;
}

void sync_folder(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

// Writes all of the files or none. An existing file is an error. After a power cut each file is
// whole or absent.
Status write_new_files(const std::vector<NewFile>& files) {
  std::vector<fs::path> written;
  for (const NewFile& file : files) {
    const fs::path folder = file.path.has_parent_path() ? file.path.parent_path() : ".";
    std::string temporary = folder / ("." + file.path.filename().string() + ".XXXXXX");
    int error = write_temporary(file, &temporary);
    // Unlike rename, link does not replace a file.
    if (error == 0 && link(temporary.c_str(), file.path.c_str()) != 0) error = errno;
    unlink(temporary.c_str());
    if (error != 0) {
      for (const auto& path : written) unlink(path.c_str());
      return not_written(file.path, error);
    }
    written.push_back(file.path);
    sync_folder(folder);
  }
  return ok();
}

constexpr size_t kMaxNameLength = 64;  // of a subject, RFC 5280
constexpr size_t kMaxLabelLength = 63;
constexpr mode_t kSecret = 0600, kPublic = 0644, kOwnFolder = 0700;
constexpr const char* kAuthority = "ca";

bool is_address(const std::string& name) {
  unsigned char bytes[sizeof(in6_addr)];
  return inet_pton(AF_INET, name.c_str(), bytes) == 1 ||
         inet_pton(AF_INET6, name.c_str(), bytes) == 1;
}

bool is_label(std::string_view label) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
  };
  return !label.empty() && label.size() <= kMaxLabelLength && label.front() != '-' &&
         label.back() != '-' && std::all_of(label.begin(), label.end(), is_allowed);
}

// A host name; `*` may stand for its first label.
bool is_host_name(std::string_view name, bool with_wildcard) {
  if (with_wildcard && name.starts_with("*.")) name.remove_prefix(2);
  if (name.empty()) return false;
  for (size_t begin = 0; begin <= name.size();) {
    const size_t end = std::min(name.find('.', begin), name.size());
    if (!is_label(name.substr(begin, end - begin))) return false;
    begin = end + 1;
  }
  return true;
}

Status check_name(const std::string& name) {
  if (name.size() <= kMaxNameLength && name != kAuthority &&
      (is_address(name) || is_host_name(name, false)))
    return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = name == kAuthority ? "this name is the authority's own"
                                          : "a certificate cannot have this name",
               .offered = "'" + name + "'",
               .needed =
                   "the host name or IP address of a server, or a name for a client: "
                   "letters, digits, '-', '_' and '.', 64 at most",
               .fix = "weir pki issue server.example"};
}

Status check_alternative(const std::string& name) {
  constexpr size_t kMaxHostNameLength = 253;
  if (name.size() <= kMaxHostNameLength && (is_address(name) || is_host_name(name, true)))
    return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "--san has a name that a certificate cannot have",
               .offered = "'" + name + "'",
               .needed = "host names, which may begin with '*.', and IP addresses",
               .fix = "--san server.example,10.0.0.5"};
}

Result<std::string> read_authority_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (file && !text.empty()) return text;
  const std::string folder = path.parent_path().string();
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = "a file of the certificate authority cannot be read",
               .offered = path.string(),
               .needed = "a folder that weir pki init made",
               .fix = "weir pki init " + shell_word(folder) + ", or --dir FOLDER"};
}

Status make_folder(const fs::path& folder) {
  std::error_code failed;
  if (fs::is_directory(folder, failed)) return ok();
  if (folder.has_parent_path()) fs::create_directories(folder.parent_path(), failed);
  if (mkdir(folder.c_str(), kOwnFolder) == 0) return ok();
  const int error = errno;
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "the folder cannot be created: " + std::generic_category().message(error),
               .offered = folder.string(),
               .needed = "a folder that you may write to",
               .fix = "weir pki init ANOTHER-FOLDER"};
}

// The key first: a certificate without its key would be of no use.
Status write_pair(const fs::path& folder, const std::string& name, const Certificate& pair) {
  return write_new_files({{folder / (name + ".key"), pair.key, kSecret},
                          {folder / (name + ".pem"), pair.certificate, kPublic}});
}

int print_pair(const PkiOptions& options, const std::string& name,
               const std::vector<std::string>& names, const Certificate& pair) {
  const fs::path folder = options.folder;
  const std::string certificate = folder / (name + ".pem"), key = folder / (name + ".key");
  if (options.json) {
    Json out{{"certificate", certificate}, {"key", key}, {"valid_until", pair.valid_until}};
    if (!names.empty()) out["names"] = names;
    print(out);
    return kExitGood;
  }
  const std::string what = names.empty() ? "certificate of the authority; copy it to every peer"
                                         : "certificate of " + join(names, ", ");
  std::fputs(table({{certificate, what + ", valid until " + pair.valid_until},
                    {key, names.empty() ? "its key; keep it secret" : "its key"}},
                   "")
                 .c_str(),
             stdout);
  return kExitGood;
}

}  // namespace

int pki_init(const PkiOptions& options) {
  if (auto status = make_folder(options.folder); !status)
    return report(status.error(), options.json);
  const auto made = make_authority(options.days);
  if (!made) return report(made.error(), options.json);
  if (auto status = write_pair(options.folder, kAuthority, *made); !status)
    return report(status.error(), options.json);
  return print_pair(options, kAuthority, {}, *made);
}

int pki_issue(const PkiOptions& options) {
  if (auto status = check_name(options.name); !status) return report(status.error(), options.json);
  std::vector<std::string> names{options.name};
  for (const auto& name : options.alternatives) {
    if (auto status = check_alternative(name); !status) return report(status.error(), options.json);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  const fs::path folder = options.folder;
  Certificate authority;
  for (const auto& [text, file] :
       {std::pair{&authority.certificate, "ca.pem"}, {&authority.key, "ca.key"}}) {
    auto read = read_authority_file(folder / file);
    if (!read) return report(read.error(), options.json);
    *text = *std::move(read);
  }
  const auto made = issue_certificate(authority, names, options.days);
  if (!made) return report(made.error(), options.json);
  if (auto status = write_pair(folder, options.name, *made); !status)
    return report(status.error(), options.json);
  return print_pair(options, options.name, names, *made);
}

}  // namespace weir::app
