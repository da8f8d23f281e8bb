// Paths of local streams: files in the way, stale sockets, rights.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <fstream>

#include "transport/local/local_stream_test_support.hpp"

namespace weir::local::test {
namespace local_socket_test {

// A socket file without a listener, as of a process that was killed.
void leave_stale_socket(const std::string& path) {
  const Descriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  ASSERT_EQ(bind(socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
}

TEST(LocalSocket, OnlyTheUserCanConnect) {
  const Folder folder;
  const auto listener = Listener::open(folder.file());
  ASSERT_TRUE(listener);
  struct stat found {};
  ASSERT_EQ(lstat(folder.file().c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 07777, 0600u);
}

TEST(LocalSocket, TheFileEndsWithTheListener) {
  const Folder folder;
  ASSERT_TRUE(Listener::open(folder.file()));
  EXPECT_FALSE(std::filesystem::exists(folder.file()));
}

TEST(LocalSocket, AStaleFileIsReplaced) {
  const Folder folder;
  leave_stale_socket(folder.file());
  EXPECT_TRUE(Listener::open(folder.file()));
}

TEST(LocalSocket, AFileOfAnotherListenerStays) {
  const Folder folder;
  const auto first = Listener::open(folder.file());
  EXPECT_REFUSED(Listener::open(folder.file()), OPTION_VALUE,
                 "another process already listens on it");
  EXPECT_TRUE(connect_to(folder.file()));
}

TEST(LocalSocket, AFileThatIsNoSocketIsNotRemoved) {
  const Folder folder;
  std::ofstream(folder.file()) << "mine";
  EXPECT_REFUSED(Listener::open(folder.file()), OPTION_VALUE, "not a socket");
  EXPECT_TRUE(std::filesystem::exists(folder.file()));
}

TEST(LocalSocket, PathsThatCannotBeUsed) {
  EXPECT_REFUSED(Listener::open(""), OPTION_VALUE, "it is empty");
  EXPECT_REFUSED(Listener::open("/tmp/" + std::string(120, 'x')), OPTION_VALUE, "more than 107");
  EXPECT_REFUSED(Listener::open("/nonexistent/folder/stream"), OPTION_VALUE, "No such file");
  EXPECT_REFUSED(connect_to(""), OPTION_VALUE, "it is empty");
}

TEST(LocalSocket, AMissingWriterIsNamedWithTheFix) {
  const Folder folder;
  EXPECT_REFUSED(connect_to(folder.file()), SERVER_UNREACHABLE, folder.file());
  EXPECT_SAYS(connect_to(folder.file()).error().fix, "reconnect=true");
}

}  // namespace local_socket_test
}  // namespace weir::local::test
