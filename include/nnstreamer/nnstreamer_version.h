/* The release of NNStreamer's interface that these headers and libnnstreamer.so implement, which is
 * not the version of Weir.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef NNSTREAMER_VERSION_H
#define NNSTREAMER_VERSION_H

#define NNSTREAMER_VERSION_MAJOR 2
#define NNSTREAMER_VERSION_MINOR 7
#define NNSTREAMER_VERSION_MICRO 0
#define NNSTREAMER_VERSION "2.7.0"

/* True for this release and later ones, for #if. */
#define NNSTREAMER_CHECK_VERSION(major, minor, micro) \
  (NNSTREAMER_VERSION_MAJOR > (major) ||              \
   (NNSTREAMER_VERSION_MAJOR == (major) &&            \
    (NNSTREAMER_VERSION_MINOR > (minor) ||            \
     (NNSTREAMER_VERSION_MINOR == (minor) && NNSTREAMER_VERSION_MICRO >= (micro)))))

#endif /* NNSTREAMER_VERSION_H */
