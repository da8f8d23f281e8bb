/* Weir Results, version 1: the tensors in which results of networks travel between elements.
 *
 * A frame of results is a frame of a tensor stream whose caps have the field weir-columns: one
 * entry for each tensor, separated by ';'. An entry is empty (not a result), the name of a table
 * (masks, scores, class-map, depth, text), or the list of the columns of rows:
 *
 *   other/tensors, format=flexible, framerate=30/1,
 *     weir-columns="x1,y1,x2,y2,score,class,track,parent,rotation,xys:17;masks",
 *     weir-source="yolo11n-pose;yolo11n-pose"
 *
 * Rows are float32, dimensions L:N (innermost first): N objects of L numbers.
 *   x1, y1, x2, y2   edges of the box in pixels of the source picture; integers are the edges
 *                    between pixels, (0, 0) is the top left corner
 *   score            0 to 1; 0: the row is background, to be skipped
 *   class            index from 0
 *   track            1 to 2^24 - 1 of an object that is followed over time; 0 = none
 *   parent           number of the row that this row belongs to, counted from 0 through all rows
 *                    of the frame, in the order of their tensors; -1 = none
 *   rotation         clockwise rotation of the box about its centre, in radians
 *   xy:P, xys:P      P key points of x, y, or x, y and score, in pixels of the source picture
 * Other names are columns of one number, or, as NAME:P, of P numbers; readers skip them. Rows
 * without x1 are of the whole picture, or of their parent's box.
 *
 * Tables belong to the rows that precede them:
 *   masks      uint8 W:H:N: probabilities 0 to 255 over the box of each row
 *   scores     float32 C:N: the scores of all classes, for each row
 *   text       uint8 L:N: the text of each row, UTF-8, followed by zeros
 *   class-map  uint8 or uint16 W:H: the class of each pixel of the picture
 *   depth      float32 W:H: the depth of each pixel of the picture, in the network's unit
 * class-map and depth cover the whole source picture unless the buffer's source map says otherwise.
 *
 * A frame without results has one row of zeros. weir-source names what made each tensor: the name
 * of a model. A later version that readers of version 1 cannot read will have another field.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#ifndef WEIR_RESULTS_H
#define WEIR_RESULTS_H
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

#define WEIR_RESULTS_VERSION 1
#define WEIR_RESULTS_COLUMNS "weir-columns" /* caps fields */
#define WEIR_RESULTS_SOURCE "weir-source"
#define WEIR_RESULTS_TRACK_LIMIT 16777216 /* track numbers are below; float32 has them exactly */
#define WEIR_RESULTS_ROW_LIMIT 65536      /* numbers in a row */

enum weir_result_kind {
  WEIR_RESULT_NONE = 0, /* not a result */
  WEIR_RESULT_ROWS,
  WEIR_RESULT_MASKS,
  WEIR_RESULT_SCORES,
  WEIR_RESULT_CLASS_MAP,
  WEIR_RESULT_DEPTH,
  WEIR_RESULT_TEXT
};

/* Where the columns of a row are: the index of the first number, -1 = there is no such column. */
typedef struct {
  uint32_t kind;   /* weir_result_kind; the rest is of rows */
  uint32_t length; /* numbers in a row */
  int32_t box;     /* x1, y1, x2, y2 */
  int32_t score, class_index, track, parent, rotation;
  int32_t points;        /* key points */
  uint32_t n_points;     /* of a row */
  uint32_t point_length; /* 2: x, y; 3: x, y, score */
} weir_result_columns;

/* Returns whether the `length` characters at `text` are `name`. */
static inline int weir_results_equal(const char* text, size_t length, const char* name) {
  return strlen(name) == length && memcmp(text, name, length) == 0;
}

/* Adds the column that is written at `text`; `edges` counts those of the box. Returns 0 if it is
 * not valid. */
static inline int weir_results_add_column(const char* text, size_t length, uint32_t* edges,
                                          weir_result_columns* out) {
  static const char kEdges[4][3] = {"x1", "y1", "x2", "y2"};
  const int32_t at = (int32_t)out->length;
  size_t name = 0, i;
  uint32_t count = 1;
  while (name < length && text[name] != ':') ++name;
  if (name == 0) return 0;
  if (name < length) { /* NAME:P */
    if (name + 1 == length) return 0;
    count = 0;
    for (i = name + 1; i < length; ++i) {
      if (text[i] < '0' || text[i] > '9') return 0;
      count = count * 10 + (uint32_t)(text[i] - '0');
      if (count > WEIR_RESULTS_ROW_LIMIT) return 0;
    }
    if (count == 0) return 0;
  }
  for (i = 0; i < 4; ++i) {
    if (!weir_results_equal(text, length, kEdges[i])) continue;
    if (*edges != i || (i > 0 && at != out->box + (int32_t)i)) return 0;
    if (i == 0) out->box = at;
    ++*edges;
  }
  {
    struct {
      const char* name;
      int32_t* index;
    } const known[5] = {{"score", &out->score},
                        {"class", &out->class_index},
                        {"track", &out->track},
                        {"parent", &out->parent},
                        {"rotation", &out->rotation}};
    for (i = 0; i < 5; ++i) {
      if (!weir_results_equal(text, length, known[i].name)) continue;
      if (*known[i].index >= 0) return 0;
      *known[i].index = at;
    }
  }
  if (weir_results_equal(text, name, "xy") || weir_results_equal(text, name, "xys")) {
    if (out->points >= 0 || name == length) return 0;
    out->points = at;
    out->n_points = count;
    out->point_length = (uint32_t)name;
    count *= out->point_length;
  }
  if (count > WEIR_RESULTS_ROW_LIMIT - out->length) return 0;
  out->length += count;
  return 1;
}

/* Reads the entry of tensor `index` of a weir-columns text, which may be NULL. Returns 1 and fills
 * `out`; an entry that is missing has the kind NONE. Returns 0 if the entry is not valid: a column
 * twice, edges of the box that are not together and in order, an empty name, a row of more than
 * 65536 numbers, rows with a box that has fewer than four edges. */
static inline int weir_results_parse(const char* text, uint32_t index, weir_result_columns* out) {
  static const struct {
    const char* name;
    uint32_t kind;
  } kTables[5] = {{"masks", WEIR_RESULT_MASKS},
                  {"scores", WEIR_RESULT_SCORES},
                  {"class-map", WEIR_RESULT_CLASS_MAP},
                  {"depth", WEIR_RESULT_DEPTH},
                  {"text", WEIR_RESULT_TEXT}};
  const char* end;
  uint32_t edges = 0;
  size_t i;
  memset(out, 0, sizeof *out);
  out->box = out->score = out->class_index = out->track = out->parent = out->rotation = -1;
  out->points = -1;
  if (!text) return 1;
  for (; index > 0; --index) {
    text = strchr(text, ';');
    if (!text) return 1;
    ++text;
  }
  end = strchr(text, ';');
  if (!end) end = text + strlen(text);
  if (text == end) return 1;
  for (i = 0; i < 5; ++i)
    if (weir_results_equal(text, (size_t)(end - text), kTables[i].name)) {
      out->kind = kTables[i].kind;
      return 1;
    }
  out->kind = WEIR_RESULT_ROWS;
  while (text <= end) {
    const char* comma = (const char*)memchr(text, ',', (size_t)(end - text));
    const char* stop = comma ? comma : end;
    if (!weir_results_add_column(text, (size_t)(stop - text), &edges, out)) return 0;
    text = stop + 1;
  }
  return edges == 0 || edges == 4;
}

#ifdef __cplusplus
}
#endif
#endif /* WEIR_RESULTS_H */
