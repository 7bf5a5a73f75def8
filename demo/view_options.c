#include "view_options.h"

#include <stdlib.h>
#include <string.h>

#include "arguments.h"
#include "camera.h"

static const char usage[] =
    "Usage: scree-view SCENE.json [options]\n"
    "       scree-view SCENE.json --headless --screenshot FILE.png [options]\n"
    "       scree-view HOODOO.json [options]\n"
    "\n"
    "Shows a scene in a window to fly through and edit, or draws one picture of it without a display. A recipe of a hoodoo\n"
    "(\"kind\": \"hoodoo\") is weathered instead, by hand: with graphs of durability and bubbles, forwards and back in time.\n"
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
    "      --rocks WHICH     visible, or all: those that nobody can see behind their neighbours, too, which draws the same\n"
    "                        picture and takes longer; default: visible\n"
    "      --lod L           one level of detail for every stone, 0 is the finest; default: what each needs on the screen\n"
    "      --pixel-error X   pixels between two levels, at most, when one is chosen, 0.05..50; default: 2\n"
    "      --colour WHAT     stone, or what tells: lod (level of detail) or tile (code of the corner cube); of a recipe\n"
    "                        durability or curvature\n"
    "      --weather FILE    weather this recipe, without a look at its kind\n"
    "      --variant N       the variant of the recipe, from 0; default: 0\n"
    "      --steps N         steps to take before the first picture, 0..1000000; default: 0\n"
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

const char weather_keys[] =
    "Space            play or pause\n"
    "Right, Left      one step on, one step back\n"
    "Backspace        back to the start\n"
    "drag in a graph  move a point of durability, a border of bubbles\n"
    "  click a line   a new point; right click: noise, or remove it\n"
    "Delete           remove the selected point\n"
    "K                keep this age\n"
    "Ctrl+S           save the recipe\n"
    "E                export the surface as .glb\n"
    "PgUp, PgDn       another variant\n"
    "1 2 3            colour: stone, durability, curvature\n"
    "G                wireframe\n"
    "left drag        orbit\n"
    "middle drag      pan\n"
    "wheel            nearer, farther\n"
    "Home             the first view\n"
    "P                save the picture\n"
    "Tab, F1, F3      panel, help, figures\n"
    "Ctrl+Q           quit\n";

static int complain(const char* what, const char* why) {
  fprintf(stderr, "scree-view: %s: %s\n", what, why);
  return 2;
}

static bool size(const char* text, view_options* out) {
  char *middle, *end;
  const long width = strtol(text, &middle, 10);
  if (middle == text || *middle != 'x') return false;
  const long height = strtol(middle + 1, &end, 10);
  if (end == middle + 1 || *end != 0 || width < 16 || width > 8192 || height < 16 || height > 8192) return false;
  out->width = (uint32_t)width;
  out->height = (uint32_t)height;
  return true;
}

static void print_keys(const char* title, const char* keys) {
  printf("%s:\n", title);
  for (const char* line = keys; *line != 0;) {
    size_t length = strcspn(line, "\n");
    printf("  %.*s\n", (int)length, line);
    line += length + 1;
  }
}

static int show_help(void) {
  fputs(usage, stdout);
  print_keys("In the window", view_keys);
  print_keys("\nWhile a recipe weathers", weather_keys);
  printf(
      "\nExit status: 0 done, 1 the machine failed (memory, disk, no OpenGL), 2 a mistake in the arguments, the scene or the "
      "recipe.\n");
  return 0;
}

int view_options_parse(int count, char** arguments, view_options* out) {
  memset(out, 0, sizeof *out);
  out->width = 1280;
  out->height = 720;
  out->lod = -1;
  const char *size_text = NULL, *eye = NULL, *samples = NULL, *lod = NULL, *pixel_error = NULL, *colour = NULL, *rocks = "visible";
  const char *variant = NULL, *steps = NULL;
  bool help = false, version = false;
  const argument known[] = {
      {"--packs", NULL, &out->paths.packs, NULL},
      {"--data", NULL, &out->paths.data, NULL},
      {"--screenshot", NULL, &out->screenshot, NULL},
      {"--log", NULL, &out->log, NULL},
      {"--size", NULL, &size_text, NULL},
      {"--camera", NULL, &eye, NULL},
      {"--samples", NULL, &samples, NULL},
      {"--rocks", NULL, &rocks, NULL},
      {"--lod", NULL, &lod, NULL},
      {"--pixel-error", NULL, &pixel_error, NULL},
      {"--colour", NULL, &colour, NULL},
      {"--weather", NULL, &out->weather, NULL},
      {"--variant", NULL, &variant, NULL},
      {"--steps", NULL, &steps, NULL},
      {"--headless", NULL, NULL, &out->headless},
      {"--wireframe", NULL, NULL, &out->wireframe},
      {"--no-indirect", NULL, NULL, &out->no_indirect},
      {"--no-panel", NULL, NULL, &out->no_panel},
      {"--help", "-h", NULL, &help},
      {"--version", NULL, NULL, &version},
  };
  size_t scenes;
  scree_error error;
  if (!arguments_read(count, arguments, known, sizeof known / sizeof *known, &out->paths.scene, 1, &scenes, &error)) {
    fprintf(stderr, "scree-view: %s\n", error.message);
    return 2;
  }
  if (help) return show_help();
  if (version) return printf("scree-view %s\n", scree_version_string()) < 0;
  if (size_text != NULL && !size(size_text, out)) return complain(size_text, "--size takes WIDTHxHEIGHT, each 16..8192");
  if (eye != NULL && !camera_parse(eye, out->eye, out->target, &out->field_of_view))
    return complain(eye, "--camera takes ex,ey,ez,tx,ty,tz or ex,ey,ez,tx,ty,tz,fov with fov in 1..170 degrees");
  out->has_camera = eye != NULL;
  uint32_t level;
  if ((samples != NULL && !arguments_number("--samples", samples, 1, 256, &out->samples, &error)) ||
      (lod != NULL && !arguments_number("--lod", lod, 0, RENDER_LODS - 1, &level, &error)) ||
      (variant != NULL && !arguments_number("--variant", variant, 0, 254, &out->variant, &error)) ||
      (steps != NULL && !arguments_number("--steps", steps, 0, 1000000, &out->steps, &error))) {
    fprintf(stderr, "scree-view: %s\n", error.message);
    return 2;
  }
  out->all_rocks = strcmp(rocks, "all") == 0;
  if (!out->all_rocks && strcmp(rocks, "visible") != 0) return complain(rocks, "--rocks takes visible or all");
  if (lod != NULL) out->lod = (int32_t)level;
  if (pixel_error != NULL) {
    char* end;
    out->pixel_error = strtof(pixel_error, &end);
    if (end == pixel_error || *end != 0 || !(out->pixel_error >= 0.05f && out->pixel_error <= 50))
      return complain(pixel_error, "--pixel-error takes a number from 0.05 to 50");
  }
  if (colour != NULL) {
    static const char* const words[] = {"stone", "lod", "tile", "durability", "curvature"};
    int i = 0;
    while (i < 5 && strcmp(colour, words[i]) != 0) ++i;
    if (i == 5) return complain(colour, "--colour takes stone, lod or tile, and with a recipe stone, durability or curvature");
    if (i < 3)
      out->colour = (render_colour)i;
    else
      out->paint = (weather_colour)(i - 2);
    out->tells_levels = i == 1 || i == 2;
    out->tells_weather = i > 2;
  }
  if (scenes > 0 && out->weather != NULL) return complain(out->paths.scene, "--weather takes the place of a scene");
  if (scenes == 0 && out->weather == NULL) return complain("no scene", "see --help");
  if (out->headless && out->screenshot == NULL) return complain("--headless", "give --screenshot FILE.png; see --help");
  return -1;
}

void view_options_weather(view_options* options) {
  options->weather = options->paths.scene;
}

int view_options_check(const view_options* options) {
  const char* file = options->weather != NULL ? options->weather : options->paths.scene;
  if (options->weather != NULL && options->tells_levels)
    return complain(file, "a recipe is coloured by stone, durability or curvature, see --colour");
  if (options->weather == NULL && options->tells_weather)
    return complain(file, "a scene is coloured by stone, lod or tile, see --colour");
  if (options->weather == NULL && (options->steps > 0 || options->variant > 0))
    return complain(file, "--steps and --variant are for recipes of hoodoos");
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
