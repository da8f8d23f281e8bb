// Tests which prefix an installed file belongs to.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/config/install_paths.hpp"

#include <gtest/gtest.h>

#include <array>

namespace weir::config {
namespace install_paths_test {

constexpr std::array<std::string_view, 4> kFolders{"lib/x86_64-linux-gnu/gstreamer-1.0",
                                                   "lib/x86_64-linux-gnu", "bin", "libexec/weir"};

std::string prefix(std::string_view file) {
  return find_prefix(file, kFolders, "/usr/local");
}

TEST(MovedPrefix, IsWhatIsBeforeTheFolderOfAnInstalledFile) {
  EXPECT_EQ(prefix("/opt/weir/lib/x86_64-linux-gnu/gstreamer-1.0/libgstweir.so"), "/opt/weir");
  EXPECT_EQ(prefix("/opt/weir/lib/x86_64-linux-gnu/libweir.so.0"), "/opt/weir");
  EXPECT_EQ(prefix("/opt/a b/bin/weir"), "/opt/a b");
  EXPECT_EQ(prefix("/x/libexec/weir/weir-worker"), "/x");
  EXPECT_EQ(prefix("/usr/local/bin/weir"), "/usr/local") << "where it was installed to";
  EXPECT_EQ(prefix("/bin/weir"), "/");
}

TEST(MovedPrefix, IsThatOfTheBuildForOtherFiles) {
  for (const char* file :
       {"/opt/build/src/plugin/libgstweir.so", "weir", "", "/weir", "bin/weir", "../bin/weir",
        "/opt/sbin/weir", "/opt/bin/more/weir", "/opt/lib/gstreamer-1.0/libgstweir.so"})
    EXPECT_EQ(prefix(file), "/usr/local") << file;
}

TEST(MovedPrefix, PathsBelowThePrefixMoveWithIt) {
  EXPECT_EQ(below_prefix("/usr/local/share/weir", "/usr/local", "/opt/w"), "/opt/w/share/weir");
  EXPECT_EQ(below_prefix("/usr/local/share", "/usr/local", "/"), "/share");
  EXPECT_EQ(below_prefix("/share", "/", "/opt"), "/opt/share");
  EXPECT_EQ(below_prefix("/usr/local/share", "/usr/local", "/usr/local"), "/usr/local/share");
}

TEST(MovedPrefix, OtherPathsStay) {
  for (const char* path : {"/etc", "/usr/localhost/share", "/usr/local", "", "/usr"})
    EXPECT_EQ(below_prefix(path, "/usr/local", "/opt/w"), path);
}

}  // namespace install_paths_test
}  // namespace weir::config
