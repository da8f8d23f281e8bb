// testing::TempDir() is a folder of this process alone: test programs, and parts of one, run beside
// each other and beside those of other checkouts. Linked whole into each test program.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace {

class TempFolder {
 public:
  TempFolder() {
    const char* given = std::getenv(kVariable);
    if (given && access(given, W_OK) == 0) return;
    std::string name = std::filesystem::temp_directory_path() / "weir-test-XXXXXX";
    if (!mkdtemp(name.data())) return;
    chmod(name.c_str(), 0755);  // tests become other users
    setenv(kVariable, name.c_str(), 1);
    folder_ = name;
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  ~TempFolder() {
    std::error_code failed;
    if (!folder_.empty() && getpid() == process_) std::filesystem::remove_all(folder_, failed);
  }

 private:
  static constexpr const char* kVariable = "TEST_TMPDIR";  // GoogleTest's
  std::filesystem::path folder_;
  const pid_t process_ = getpid();  // a forked one ends before the others
};

const TempFolder temp_folder;

}  // namespace
