/* Worker process for the fuzz target worker_response: sends the file WEIR_FUZZ_RESPONSES to the
 * pipeline, whatever is requested, and exits when the pipeline closes the connection.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <fcntl.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

enum { kSocket = 3 };

int main(void) {
  char buffer[65536];
  const char* path = getenv("WEIR_FUZZ_RESPONSES");
  int file = path ? open(path, O_RDONLY) : -1;
  ssize_t got;
  if (file < 0) return 2;
  while ((got = read(file, buffer, sizeof buffer)) > 0) {
    ssize_t sent = 0;
    while (sent < got) {
      ssize_t now = send(kSocket, buffer + sent, (size_t)(got - sent), MSG_NOSIGNAL);
      if (now < 0) return 0; /* the pipeline has stopped reading */
      sent += now;
    }
  }
  shutdown(kSocket, SHUT_WR);
  while (read(kSocket, buffer, sizeof buffer) > 0) continue;
  return 0;
}
