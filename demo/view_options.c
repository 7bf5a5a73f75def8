#include "view_options.h"

#include <stdlib.h>
#include <string.h>

#include "camera.h"

static const char usage[] =
    "Usage: scree-view SCENE.json [options]\n"
    "       scree-view SCENE.json --headless --screenshot FILE.png [options]\n"
    "\n"
    "Shows a scene in a window to fly through and edit, or draws one picture of it without a display.\n"
    "\n"
    "      --packs DIR       where packs that are named without a path lie; default: " SCENE_DEFAULT_PACKS
    "\n"
    "      --data DIR        where meshes and pictures lie that are not beside the scene; default: " SCENE_DEFAULT_DATA
    "\n"
    "      --headless        no window: draw through EGL into the file of --screenshot, and end\n"
    "      --screenshot FILE the PNG to write; with a window, the one that key P writes; default there: scree-view.png\n"
    "      --size WxH        pixels, 16..8192 each; default: 1280x720\n"
    "      --camera E,T[,F]  eye ex,ey,ez and target tx,ty,tz in metres, vertical field of view in degrees: 8,5,9,0,1,0,40;\n"
    "                        default: the scene's\n"
    "      --samples N       jittered samples a pixel, 1..256; default: 8, and as many as patience gives in a window\n"
    "      --lod L           one level of detail for every stone, 0 is the finest; default: what each needs on the screen\n"
    "      --pixel-error X   pixels between two levels, at most, when one is chosen, 0.05..50; default: 2\n"
    "      --colour WHAT     stone, or what tells: lod (level of detail) or tile (code of the corner cube)\n"
    "      --wireframe       draw the edges of the meshes as well\n"
    "      --no-indirect     draw with what OpenGL 3.3 has, even where there is more\n"
    "      --no-panel        start the window without its panel\n"
    "      --log FILE        write a line for each thing that happens; - is standard output\n"
    "      --help, --version\n"
    "\n";

const char view_keys[] =
    "left drag        select a support and move it over the ground\n"
    "  with Shift     move it up and down\n"
    "  with Ctrl      make it larger or smaller\n"
    "  on an arrow    move it along that axis\n"
    "right drag       orbit; look around when flying\n"
    "middle drag      pan\n"
    "wheel            nearer, farther\n"
    "F                fly or orbit; W A S D and E Q move, Shift is faster\n"
    "Home             the scene's own camera\n"
    "Z                look at the selected support\n"
    "1 2 3            colour: stone, level of detail, tile code\n"
    "G                wireframe\n"
    "Delete           remove the selected support\n"
    "Ctrl+D           duplicate it\n"
    "Ctrl+Z, Ctrl+Y   undo, redo\n"
    "Ctrl+S           save the scene\n"
    "P                save the picture\n"
    "Tab, F1, F3      panel, help, figures\n"
    "Esc              select nothing\n"
    "Ctrl+Q           quit\n";

static int complain(const char* what, const char* why) {
  fprintf(stderr, "scree-view: %s: %s\n", what, why);
  return 2;
}

static bool number(const char* text, long low, long high, long* out) {
  char* end;
  *out = strtol(text, &end, 10);
  return end != text && *end == 0 && *out >= low && *out <= high;
}

static bool size(const char* text, view_options* out) {
  char* end;
  long width = strtol(text, &end, 10), height;
  if (end == text || *end != 'x' || width < 16 || width > 8192 || !number(end + 1, 16, 8192, &height)) return false;
  out->width = (uint32_t)width;
  out->height = (uint32_t)height;
  return true;
}

/* Options without a value; returns false when it is none of them. */
static bool parse_flag(const char* name, view_options* out) {
  const struct {
    const char* name;
    bool* flag;
  } flags[] = {{"--headless", &out->headless},
               {"--wireframe", &out->wireframe},
               {"--no-indirect", &out->no_indirect},
               {"--no-panel", &out->no_panel}};
  for (size_t i = 0; i < sizeof flags / sizeof *flags; ++i)
    if (strcmp(name, flags[i].name) == 0) return *flags[i].flag = true;
  return false;
}

/* Returns -1 to go on. */
static int parse_value(const char* name, const char* value, view_options* out) {
  long n;
  if (strcmp(name, "--packs") == 0) {
    out->paths.packs = value;
  } else if (strcmp(name, "--data") == 0) {
    out->paths.data = value;
  } else if (strcmp(name, "--screenshot") == 0) {
    out->screenshot = value;
  } else if (strcmp(name, "--log") == 0) {
    out->log = value;
  } else if (strcmp(name, "--size") == 0) {
    if (!size(value, out)) return complain(value, "--size takes WIDTHxHEIGHT, each 16..8192");
  } else if (strcmp(name, "--camera") == 0) {
    if (!camera_parse(value, out->eye, out->target, &out->field_of_view))
      return complain(value, "--camera takes ex,ey,ez,tx,ty,tz or ex,ey,ez,tx,ty,tz,fov with fov in 1..170 degrees");
    out->has_camera = true;
  } else if (strcmp(name, "--samples") == 0) {
    if (!number(value, 1, 256, &n)) return complain(value, "--samples takes a number from 1 to 256");
    out->samples = (uint32_t)n;
  } else if (strcmp(name, "--lod") == 0) {
    if (!number(value, 0, RENDER_LODS - 1, &n)) return complain(value, "--lod takes a level from 0 to 5");
    out->lod = (int32_t)n;
  } else if (strcmp(name, "--pixel-error") == 0) {
    char* end;
    out->pixel_error = strtof(value, &end);
    if (end == value || *end != 0 || !(out->pixel_error >= 0.05f && out->pixel_error <= 50))
      return complain(value, "--pixel-error takes a number from 0.05 to 50");
  } else if (strcmp(name, "--colour") == 0) {
    static const char* const words[] = {"stone", "lod", "tile"};
    int i = 0;
    while (i < 3 && strcmp(value, words[i]) != 0) ++i;
    if (i == 3) return complain(value, "--colour takes stone, lod or tile");
    out->colour = (render_colour)i;
  } else {
    return complain(name, "unknown option; see --help");
  }
  return -1;
}

int view_options_parse(int count, char** arguments, view_options* out) {
  memset(out, 0, sizeof *out);
  out->width = 1280;
  out->height = 720;
  out->lod = -1;
  for (int i = 1; i < count; ++i) {
    const char* name = arguments[i];
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
      fputs(usage, stdout);
      printf("In the window:\n");
      for (const char* line = view_keys; *line != 0;) {
        size_t length = strcspn(line, "\n");
        printf("  %.*s\n", (int)length, line);
        line += length + 1;
      }
      printf("\nExit status: 0 done, 1 the machine failed (memory, disk, no OpenGL), 2 a mistake in the arguments or the scene.\n");
      return 0;
    }
    if (strcmp(name, "--version") == 0) {
      printf("scree-view %s\n", scree_version_string());
      return 0;
    }
    if (name[0] != '-' || name[1] == 0) {
      if (out->paths.scene != NULL) return complain(name, "one scene at a time; see --help");
      out->paths.scene = name;
      continue;
    }
    if (parse_flag(name, out)) continue;
    static const char* const valued[] = {"--packs",  "--data",    "--screenshot", "--log",         "--size",
                                         "--camera", "--samples", "--lod",        "--pixel-error", "--colour"};
    bool known = false;
    for (size_t k = 0; k < sizeof valued / sizeof *valued; ++k) known = known || strcmp(name, valued[k]) == 0;
    if (!known) return complain(name, "unknown option; see --help");
    if (i + 1 == count) return complain(name, "needs a value; see --help");
    int status = parse_value(name, arguments[++i], out);
    if (status >= 0) return status;
  }
  if (out->paths.scene == NULL) return complain("no scene", "see --help");
  if (out->headless && out->screenshot == NULL) return complain("--headless", "give --screenshot FILE.png; see --help");
  return -1;
}

FILE* view_log_open(const view_options* options) {
  if (options->log == NULL) return NULL;
  if (strcmp(options->log, "-") == 0) return stdout;
  FILE* log = fopen(options->log, "w");
  if (log == NULL) fprintf(stderr, "scree-view: %s: cannot be written\n", options->log);
  return log;
}

void view_log_close(FILE* log) {
  if (log != NULL && log != stdout) fclose(log);
}
