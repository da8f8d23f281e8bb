/* Parses weir-columns texts with weir/results.h in C11, and prints what Python is compared with.
 *
 * results_c11 TEXT INDEX prints the members of weir_result_columns, or "invalid". Without arguments
 * it checks one text.
 *
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include "weir/results.h"

#include <stdio.h>
#include <stdlib.h>

static int check(void) {
  weir_result_columns columns;
  if (!weir_results_parse("x1,y1,x2,y2,score,xys:2;masks", 0, &columns)) return 1;
  if (columns.kind != WEIR_RESULT_ROWS || columns.length != 11 || columns.score != 4) return 2;
  if (columns.points != 5 || columns.n_points != 2 || columns.point_length != 3) return 3;
  if (!weir_results_parse("x1,y1,x2,y2,score,xys:2;masks", 1, &columns)) return 4;
  if (columns.kind != WEIR_RESULT_MASKS) return 5;
  return weir_results_parse("x1,x2,y1,y2", 0, &columns) ? 6 : 0;
}

int main(int argc, char** argv) {
  weir_result_columns c;
  if (argc != 3) return check();
  if (!weir_results_parse(argv[1], (uint32_t)atoi(argv[2]), &c)) return puts("invalid") < 0;
  printf("%u %u %d %d %d %d %d %d %d %u %u\n", c.kind, c.length, c.box, c.score, c.class_index,
         c.track, c.parent, c.rotation, c.points, c.n_points, c.point_length);
  return 0;
}
