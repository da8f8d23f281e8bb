 * SPDX-License-Identifier: LGPL-2.1-or-later */
/* A worker process for the fuzz target worker_answer: sends the file that WEIR_FUZZ_ANSWERS names
 * to the pipeline, whatever it is asked, and ends when the pipeline has closed the connection. */
#include <fcntl.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

enum { kSocket = 3 };

int main(void) {
  char buffer[65536];
  const char* path = getenv("WEIR_FUZZ_ANSWERS");
  int file = path ? open(path, O_RDONLY) : -1;
  ssize_t got;
  if (file < 0) return 2;
  while ((got = read(file, buffer, sizeof buffer)) > 0) {
    ssize_t sent = 0;
    while (sent < got) {
      ssize_t now = send(kSocket, buffer + sent, (size_t)(got - sent), MSG_NOSIGNAL);
      if (now < 0) return 0; /* the pipeline reads no more */
      sent += now;
    }
  }
  shutdown(kSocket, SHUT_WR);
  while (read(kSocket, buffer, sizeof buffer) > 0) continue;
  return 0;
}
