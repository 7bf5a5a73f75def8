/* scree-bake as people run it: what it prints, how it ends, what it leaves behind. Arguments: the program, an empty folder to work
 * in. */
#define _POSIX_C_SOURCE 200809L
#include <scree/pack.h>

#include <dirent.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

static const char* program;

typedef struct run_result {
  int status;
  char out[16384], err[16384];
} run_result;

static void read_file(const char* path, char* text, size_t capacity) {
  FILE* file = fopen(path, "rb");
  assert_non_null(file);
  text[fread(text, 1, capacity - 1, file)] = '\0';
  fclose(file);
}

static void write_text(const char* path, const char* text, size_t size) {
  FILE* file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(text, 1, size, file), size);
  fclose(file);
}

/* Runs the program with arguments as a shell reads them; its output goes through files beside the working folder. */
static void run(const char* arguments, run_result* out) {
  char command[4096];
  snprintf(command, sizeof command, "'%s' %s >../out.txt 2>../err.txt </dev/null", program, arguments);
  const int status = system(command);
  assert_true(WIFEXITED(status));
  out->status = WEXITSTATUS(status);
  read_file("../out.txt", out->out, sizeof out->out);
  read_file("../err.txt", out->err, sizeof out->err);
}

static uint32_t count_files(void) {
  DIR* directory = opendir(".");
  assert_non_null(directory);
  uint32_t count = 0;
  for (const struct dirent* entry; (entry = readdir(directory)) != NULL;) count += entry->d_name[0] != '.';
  closedir(directory);
  return count;
}

/* Ends with status 2 and one line that says each of the words; writes nothing. */
static void expect_refusal(const char* arguments, const char* first, const char* second) {
  const uint32_t before = count_files();
  run_result result;
  run(arguments, &result);
  const char* end = strchr(result.err, '\n');
  const bool one_line = end != NULL && end[1] == '\0' && end > result.err;
  if (result.status != 2 || !one_line || result.out[0] != '\0' || strstr(result.err, first) == NULL ||
      strstr(result.err, second) == NULL || strncmp(result.err, "scree-bake: ", 12) != 0)
    fail_msg("scree-bake %s ended with %d and said: %s%s", arguments, result.status, result.err, result.out);
  assert_int_equal(count_files(), before);
}

static void mistakes_end_with_status_2_and_one_line(void** state) {
  (void)state;
  write_text("good.json", "{\"n\": 4}", 8);
  write_text("syntax.json", "{\"n\": 4,\n}", 10);
  write_text("type.json", "{\"jitter\": \"a lot\"}", 19);
  write_text("range.json", "{\"n\": 99}", 9);
  write_text("unknown.json", "{\"shininess\": 1}", 16);
  write_text("twice.json", "{\"n\": 4, \"n\": 5}", 16);
  write_text("empty.json", "", 0);
  write_text("binary.json", "\0\1\2\377\376", 5);
  assert_int_equal(mkdir("folder.json", 0777), 0);
  char* huge = malloc((size_t)20 << 20);
  assert_non_null(huge);
  memset(huge, ' ', (size_t)20 << 20);
  write_text("huge.json", huge, (size_t)20 << 20);
  memset(huge, '[', 1 << 20);
  write_text("deep.json", huge, 1 << 20);
  free(huge);

  expect_refusal("missing.json -o x.scree", "missing.json", "No such file");
  expect_refusal("folder.json -o x.scree", "folder.json", "directory");
  expect_refusal("syntax.json -o x.scree", "syntax.json", "line 2");
  expect_refusal("type.json -o x.scree", "type.json", "jitter");
  expect_refusal("range.json -o x.scree", "range.json", "n: expected a whole number from 4 to 9, got 99");
  expect_refusal("unknown.json -o x.scree", "unknown.json", "shininess");
  expect_refusal("twice.json -o x.scree", "twice.json", "n: given twice");
  expect_refusal("empty.json -o x.scree", "empty.json", "JSON");
  expect_refusal("binary.json -o x.scree", "binary.json", "JSON");
  expect_refusal("deep.json -o x.scree", "deep.json", "JSON");
  expect_refusal("huge.json -o x.scree", "huge.json", "large");
  expect_refusal("", "recipe", "--help");
  expect_refusal("good.json", "output", "--help");
  expect_refusal("good.json -o", "-o", "value");
  expect_refusal("good.json good.json -o x.scree", "good.json", "one recipe");
  expect_refusal("good.json -o x.scree --shiny", "--shiny", "unknown option");
  expect_refusal("good.json -o x.scree --threads 0", "0", "--threads");
  expect_refusal("good.json -o x.scree --threads 2x", "2x", "--threads");
  expect_refusal("good.json -o x.scree --set n=99", "--set", "n: expected");
  expect_refusal("good.json -o x.scree --set n", "--set", "KEY=VALUE");
  expect_refusal("good.json -o x.scree --set shininess=1", "--set", "shininess");
  expect_refusal("good.json -o x.scree --set g=[2,1]", "--set", "g: ");
}

static void an_output_that_cannot_be_written_is_found_out_first(void** state) {
  (void)state;
  write_text("good.json", "{\"n\": 9, \"voxels_per_cell\": 28}", 31); /* would take minutes */
  expect_refusal("good.json -o nowhere/x.scree", "nowhere/x.scree", "No such file");
  expect_refusal("good.json -o good.json/x.scree", "good.json/x.scree", "directory");
  expect_refusal("good.json -o x.scree --report nowhere/r.json", "nowhere/r.json", "No such file");
  expect_refusal("good.json -o x.scree --report x.scree", "x.scree", "both");
  if (geteuid() != 0) { /* root may write anywhere */
    assert_int_equal(mkdir("locked", 0555), 0);
    expect_refusal("good.json -o locked/x.scree", "locked/x.scree", "denied");
  }
}

static void a_truncated_recipe_leaves_nothing_behind(void** state) {
  (void)state;
  static const char text[] = "{\"n\": 4, \"voxels_per_cell\": 6, \"seeds\": [1, 2], \"orientation\": \"random\"}";
  write_text("cut.json", text, 0);
  for (size_t cut = 0; cut < sizeof text - 1; ++cut) {
    write_text("cut.json", text, cut);
    expect_refusal("cut.json -o x.scree", "cut.json", "JSON");
  }
}

static void a_bake_writes_the_pack_and_the_report_and_says_nothing(void** state) {
  (void)state;
  write_text("good.json", "{\"n\": 4, \"voxels_per_cell\": 6, \"proxies\": false}", 48);
  const uint32_t before = count_files();
  run_result result;
  run("good.json -o x.scree --set lod_levels=1 --set 'name=a \"stone\"' --threads 2 --report r.json", &result);
  assert_string_equal(result.err, "");
  assert_string_equal(result.out, "");
  assert_int_equal(result.status, 0);
  assert_int_equal(count_files(), before + 2);
  scree_pack* pack;
  assert_int_equal(scree_pack_open_file("x.scree", NULL, &pack), SCREE_OK);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  assert_int_equal(info.asset_count, 2266);
  assert_int_equal(info.lod_count, 1);
  char report[16384], expected[64];
  read_file("r.json", report, sizeof report);
  snprintf(expected, sizeof expected, "\"digest\": \"%016llx\"", (unsigned long long)info.digest);
  assert_non_null(strstr(report, expected));
  snprintf(expected, sizeof expected, "\"bytes\": %zu", info.file_size);
  assert_non_null(strstr(report, expected));
  static const char* const keys[] = {"\"rocks\": 2266", "\"triangles\": ", "\"seconds\": ", "\"a \\\"stone\\\"\""};
  for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) assert_non_null(strstr(report, keys[i]));
  scree_pack_close(pack);

  /* A second bake that is refused leaves the first pack alone. */
  expect_refusal("good.json -o x.scree --set n=3", "--set", "n: ");
  assert_int_equal(scree_pack_open_file("x.scree", NULL, &pack), SCREE_OK);
  assert_int_equal(scree_pack_verify(pack), SCREE_OK);
  scree_pack_close(pack);
}

/* A pipe stands for /dev/null, which root could replace by a file. */
static void a_device_is_written_to_and_not_replaced(void** state) {
  (void)state;
  write_text("good.json", "{\"n\": 4, \"voxels_per_cell\": 6, \"proxies\": false}", 48);
  assert_int_equal(mkfifo("pipe", 0600), 0);
  const int reader = open("pipe", O_RDONLY | O_NONBLOCK);
  assert_true(reader >= 0);
  const uint32_t before = count_files();
  run_result result;
  run("good.json -o x.scree --set lod_levels=1 --report pipe", &result);
  assert_string_equal(result.err, "");
  assert_int_equal(result.status, 0);
  assert_int_equal(count_files(), before + 1);
  char report[16384] = "";
  assert_true(read(reader, report, sizeof report - 1) > 0);
  close(reader);
  assert_non_null(strstr(report, "\"rocks\": 2266"));
  struct stat status;
  assert_int_equal(stat("pipe", &status), 0);
  assert_true(S_ISFIFO(status.st_mode));
}

/* As /dev/stdout is one, which root could replace. */
static void a_link_is_written_through_and_not_replaced(void** state) {
  (void)state;
  write_text("good.json", "{\"n\": 4, \"voxels_per_cell\": 6, \"proxies\": false}", 48);
  write_text("target.json", "old", 3);
  assert_int_equal(symlink("target.json", "link.json"), 0);
  run_result result;
  run("good.json -o x.scree --set lod_levels=1 --report link.json", &result);
  assert_string_equal(result.err, "");
  assert_int_equal(result.status, 0);
  struct stat status;
  assert_int_equal(lstat("link.json", &status), 0);
  assert_true(S_ISLNK(status.st_mode));
  char report[16384];
  read_file("target.json", report, sizeof report);
  assert_non_null(strstr(report, "\"rocks\": 2266"));
}

static void help_version_and_the_recipe_are_printed(void** state) {
  (void)state;
  run_result result;
  run("--help", &result);
  assert_int_equal(result.status, 0);
  assert_non_null(strstr(result.out, "--set KEY=VALUE"));
  run("--version", &result);
  assert_int_equal(result.status, 0);
  assert_non_null(strstr(result.out, scree_version_string()));
  write_text("good.json", "{\"n\": 4}", 8);
  run("good.json --print-recipe --set jitter=0.5", &result);
  assert_int_equal(result.status, 0);
  assert_non_null(strstr(result.out, "\"n\": 4"));
  assert_non_null(strstr(result.out, "\"jitter\": 0.5"));
}

/* Every test in a fresh folder. */
static int enter(void** state) {
  (void)state;
  return system("rm -rf work && mkdir work") == 0 && chdir("work") == 0 ? 0 : -1;
}

static int leave(void** state) {
  (void)state;
  return chdir("..") == 0 && system("chmod -R u+w work && rm -rf work out.txt err.txt") == 0 ? 0 : -1;
}

int main(int count, char** arguments) {
  if (count != 3 || (mkdir(arguments[2], 0777) != 0 && access(arguments[2], W_OK) != 0) || chdir(arguments[2]) != 0) return 2;
  program = arguments[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(mistakes_end_with_status_2_and_one_line, enter, leave),
      cmocka_unit_test_setup_teardown(an_output_that_cannot_be_written_is_found_out_first, enter, leave),
      cmocka_unit_test_setup_teardown(a_truncated_recipe_leaves_nothing_behind, enter, leave),
      cmocka_unit_test_setup_teardown(a_bake_writes_the_pack_and_the_report_and_says_nothing, enter, leave),
      cmocka_unit_test_setup_teardown(a_device_is_written_to_and_not_replaced, enter, leave),
      cmocka_unit_test_setup_teardown(a_link_is_written_through_and_not_replaced, enter, leave),
      cmocka_unit_test_setup_teardown(help_version_and_the_recipe_are_printed, enter, leave),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
