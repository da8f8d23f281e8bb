/* Tests of ml_tensors_info_*, ml_tensors_data_* and the handles that all calls share. */
/* SPDX-License-Identifier: LGPL-2.1-or-later */
#include "check_test_support.h"

static void an_info_keeps_what_it_is_reported(void) {
  ml_tensors_info_h info = NULL, copy = NULL;
  ml_tensor_dimension picture = {3, 4, 5}, got;
  ml_tensor_type_e type;
  unsigned int count = 9;
  size_t size = 9;
  char* name = NULL;
  bool valid = true;
  OK(ml_tensors_info_create(&info));
  OK(ml_tensors_info_get_count(info, &count));
  CHECK(count == 0);
  OK(ml_tensors_info_validate(info, &valid));
  CHECK(!valid);
  OK(ml_tensors_info_set_count(info, 2));
  OK(ml_tensors_info_validate(info, &valid));
  CHECK(!valid);
  OK(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_UINT8));
  OK(ml_tensors_info_set_tensor_dimension(info, 0, picture));
  OK(ml_tensors_info_set_tensor_type(info, 1, ML_TENSOR_TYPE_FLOAT64));
  OK(ml_tensors_info_set_tensor_dimension(info, 1, picture));
  OK(ml_tensors_info_set_tensor_name(info, 1, "scores"));
  OK(ml_tensors_info_validate(info, &valid));
  CHECK(valid);
  OK(ml_tensors_info_get_tensor_size(info, 0, &size));
  CHECK(size == 3 * 4 * 5);
  OK(ml_tensors_info_get_tensor_size(info, 1, &size));
  CHECK(size == 3 * 4 * 5 * 8);
  OK(ml_tensors_info_get_tensor_size(info, -1, &size));
  CHECK(size == 3 * 4 * 5 * 9);

  OK(ml_tensors_info_create(&copy));
  OK(ml_tensors_info_clone(copy, info));
  OK(ml_tensors_info_destroy(info));
  OK(ml_tensors_info_get_tensor_dimension(copy, 1, got));
  CHECK(got[0] == 3 && got[1] == 4 && got[2] == 5 && got[3] == 0 && got[15] == 0);
  OK(ml_tensors_info_get_tensor_type(copy, 1, &type));
  CHECK(type == ML_TENSOR_TYPE_FLOAT64);
  OK(ml_tensors_info_get_tensor_name(copy, 1, &name));
  CHECK(name && strcmp(name, "scores") == 0);
  free(name);
  OK(ml_tensors_info_get_tensor_name(copy, 0, &name));
  CHECK(name == NULL);
  OK(ml_tensors_info_set_tensor_name(copy, 1, NULL));
  OK(ml_tensors_info_get_tensor_name(copy, 1, &name));
  CHECK(name == NULL);
  OK(ml_tensors_info_destroy(copy));
}

/* The order of the types is part of the wire formats: sizes 4 4 2 2 1 1 8 4 8 8 2. */
static void types_have_the_order_of_the_stream(void) {
  static const size_t sizes[] = {4, 4, 2, 2, 1, 1, 8, 4, 8, 8, 2};
  int type;
  for (type = 0; type < 11; ++type) {
    ml_tensors_info_h info = make_info((ml_tensor_type_e)type, 10, 0);
    size_t size = 0;
    OK(ml_tensors_info_get_tensor_size(info, 0, &size));
    CHECK(size == 10 * sizes[type]);
    OK(ml_tensors_info_destroy(info));
  }
}

static void an_info_refuses_what_no_tensor_is(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_INT8, 7, 0);
  ml_tensor_dimension none = {0}, hole = {3, 0, 2}, huge = {0}, got;
  ml_tensor_type_e type;
  unsigned int i;
  size_t size = 9;
  CHECK_REFUSED(ml_tensors_info_set_count(info, 0), ML_ERROR_INVALID_PARAMETER,
                "count is out of range");
  CHECK_REFUSED(ml_tensors_info_set_count(info, 257), ML_ERROR_INVALID_PARAMETER, "offered: 257");
  CHECK_REFUSED(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_UNKNOWN),
                ML_ERROR_INVALID_PARAMETER, "type is not a tensor type");
  CHECK_REFUSED(ml_tensors_info_set_tensor_type(info, 0, (ml_tensor_type_e)-1),
                ML_ERROR_INVALID_PARAMETER, "offered: -1");
  CHECK_REFUSED(ml_tensors_info_set_tensor_type(info, 1, ML_TENSOR_TYPE_INT8),
                ML_ERROR_INVALID_PARAMETER, "no tensor has this index\n  offered: 1");
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, none), ML_ERROR_INVALID_PARAMETER,
                "dimension is not a valid tensor dimension");
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, hole), ML_ERROR_INVALID_PARAMETER,
                "offered: 3:0:2:0");
  CHECK_REFUSED(ml_tensors_info_set_tensor_dimension(info, 0, NULL), ML_ERROR_INVALID_PARAMETER,
                "dimension is a null pointer");
  OK(ml_tensors_info_get_tensor_dimension(info, 0, got));
  CHECK(got[0] == 7);
  CHECK_REFUSED(ml_tensors_info_get_tensor_size(info, 1, &size), ML_ERROR_INVALID_PARAMETER,
                "needed: an index below the number of tensors: 1");
  CHECK(size == 0);
  CHECK_REFUSED(ml_tensors_info_get_tensor_size(info, -2, &size), ML_ERROR_INVALID_PARAMETER,
                "no tensor has this index\n  offered: -2");
  CHECK_REFUSED(ml_tensors_info_get_tensor_type(info, 1, &type), ML_ERROR_INVALID_PARAMETER,
                "no tensor has this index");
  CHECK(type == ML_TENSOR_TYPE_UNKNOWN);
  for (i = 0; i < 4; ++i) huge[i] = 65536;
  OK(ml_tensors_info_set_tensor_dimension(info, 0, huge));
  CHECK_REFUSED(ml_tensors_info_get_tensor_size(info, 0, &size), ML_ERROR_INVALID_PARAMETER,
                "too large");
  OK(ml_tensors_info_destroy(info));
}

static void data_is_zero_and_takes_copies(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_FLOAT32, 2, 2);
  ml_tensors_data_h data = NULL;
  const float given[4] = {1, 2, 3, 4};
  const float* values;
  OK(ml_tensors_data_create(info, &data));
  OK(ml_tensors_info_destroy(info));
  values = floats(data, 0, 4);
  CHECK(values && values[0] == 0 && values[3] == 0);
  OK(ml_tensors_data_set_tensor_data(data, 0, given, sizeof given));
  CHECK(values && values[0] == 1 && values[3] == 4);
  OK(ml_tensors_data_set_tensor_data(data, 0, &given[2], sizeof(float)));
  CHECK(values && values[0] == 3 && values[1] == 2);
  CHECK_REFUSED(
      ml_tensors_data_set_tensor_data(data, 0, given, sizeof given + 1), ML_ERROR_INVALID_PARAMETER,
      "data_size is out of range for tensor 0\n  offered: 17 bytes\n  needed: 1 to 16 bytes");
  CHECK_REFUSED(ml_tensors_data_set_tensor_data(data, 0, given, 0), ML_ERROR_INVALID_PARAMETER,
                "offered: 0 bytes");
  CHECK_REFUSED(ml_tensors_data_set_tensor_data(data, 1, given, 4), ML_ERROR_INVALID_PARAMETER,
                "no tensor has this index");
  CHECK_REFUSED(ml_tensors_data_set_tensor_data(data, 0, NULL, 4), ML_ERROR_INVALID_PARAMETER,
                "raw_data is a null pointer");
  OK(ml_tensors_data_destroy(data));
}

static void data_needs_an_info_that_is_complete(void) {
  ml_tensors_info_h info = NULL;
  ml_tensors_data_h data = &info;
  OK(ml_tensors_info_create(&info));
  CHECK_REFUSED(ml_tensors_data_create(info, &data), ML_ERROR_INVALID_PARAMETER,
                "info describes no tensor");
  CHECK(data == NULL);
  OK(ml_tensors_info_set_count(info, 1));
  OK(ml_tensors_info_set_tensor_type(info, 0, ML_TENSOR_TYPE_INT8));
  CHECK_REFUSED(ml_tensors_data_create(info, &data), ML_ERROR_INVALID_PARAMETER,
                "first difference: dimensions\n  fix: ml_tensors_info_set_tensor_dimension");
  OK(ml_tensors_info_destroy(info));
}

static void handles_differ(void) {
  ml_tensors_info_h info = make_info(ML_TENSOR_TYPE_INT8, 1, 0), again = NULL;
  ml_tensors_data_h data = NULL;
  unsigned int count;
  int number;
  OK(ml_tensors_data_create(info, &data));
  CHECK_REFUSED(ml_tensors_info_get_count(NULL, &count), ML_ERROR_INVALID_PARAMETER,
                "info is a null pointer");
  CHECK_REFUSED(ml_tensors_info_get_count(data, &count), ML_ERROR_INVALID_PARAMETER,
                "info is a handle of a different type\n  offered: a handle of type tensors data\n"
                "  needed: a handle of type tensors info");
  CHECK_REFUSED(ml_tensors_info_get_count(&number, &count), ML_ERROR_INVALID_PARAMETER,
                "info is not a handle");
  CHECK_REFUSED(ml_tensors_data_destroy(info), ML_ERROR_INVALID_PARAMETER,
                "data is a handle of a different type");
  CHECK_REFUSED(ml_tensors_info_clone(info, data), ML_ERROR_INVALID_PARAMETER, "src is a handle");
  OK(ml_tensors_info_destroy(info));
  CHECK_REFUSED(ml_tensors_info_destroy(info), ML_ERROR_INVALID_PARAMETER,
                "info is a handle that was destroyed or released");
  OK(ml_tensors_info_create(&again));
  CHECK(again != info);
  CHECK_REFUSED(ml_tensors_info_get_count(info, &count), ML_ERROR_INVALID_PARAMETER,
                "was destroyed");
  CHECK(ml_error_number() == 1004);
  CHECK_REFUSED(ml_tensors_info_create(NULL), ML_ERROR_INVALID_PARAMETER, "info is a null pointer");
  CHECK_REFUSED(ml_tensors_data_create(again, NULL), ML_ERROR_INVALID_PARAMETER,
                "data is a null pointer");
  OK(ml_tensors_info_destroy(again));
  OK(ml_tensors_data_destroy(data));
}

int main(void) {
  CHECK(strcmp(ml_error(), "") == 0 && ml_error_number() == 0);
  an_info_keeps_what_it_is_reported();
  types_have_the_order_of_the_stream();
  an_info_refuses_what_no_tensor_is();
  data_is_zero_and_takes_copies();
  data_needs_an_info_that_is_complete();
  handles_differ();
  return result_of_checks();
}
