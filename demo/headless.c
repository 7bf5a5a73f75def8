#include "headless.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <stb_image_write.h>
#include <stdio.h>
#include <stdlib.h>

#include "file.h"

struct headless {
  EGLDisplay display;
  EGLContext context;
};

static scree_result refuse(headless* h, scree_error* error, const char* what) {
  snprintf(error->message, sizeof error->message, "no OpenGL without a display: %s (EGL error 0x%x)", what,
           (unsigned)eglGetError());
  headless_destroy(h);
  return SCREE_ERROR_UNSUPPORTED;
}

scree_result headless_create(headless** out, scree_error* error) {
  *out = NULL;
  headless* h = calloc(1, sizeof *h);
  if (h == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  h->display = EGL_NO_DISPLAY;
  h->context = EGL_NO_CONTEXT;
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless"))
    return refuse(h, error, "EGL has no surfaceless platform");
  h->display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, (void*)EGL_DEFAULT_DISPLAY, NULL);
  if (h->display == EGL_NO_DISPLAY || !eglInitialize(h->display, NULL, NULL)) return refuse(h, error, "no EGL display");
  if (!eglBindAPI(EGL_OPENGL_API)) return refuse(h, error, "EGL gives no desktop OpenGL");
  static const EGLint config_wants[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = NULL;
  EGLint count = 0;
  if (!eglChooseConfig(h->display, config_wants, &config, 1, &count) || count < 1) return refuse(h, error, "no EGL configuration");
  static const EGLint versions[][2] = {{4, 6}, {4, 5}, {4, 3}, {3, 3}};
  for (size_t i = 0; i < sizeof versions / sizeof *versions && h->context == EGL_NO_CONTEXT; ++i) {
    const EGLint wants[] = {EGL_CONTEXT_MAJOR_VERSION,
                            versions[i][0],
                            EGL_CONTEXT_MINOR_VERSION,
                            versions[i][1],
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                            EGL_NONE};
    h->context = eglCreateContext(h->display, config, EGL_NO_CONTEXT, wants);
  }
  if (h->context == EGL_NO_CONTEXT) return refuse(h, error, "no OpenGL 3.3 core context");
  if (!eglMakeCurrent(h->display, EGL_NO_SURFACE, EGL_NO_SURFACE, h->context)) return refuse(h, error, "context not made current");
  *out = h;
  return SCREE_OK;
}

void headless_destroy(headless* h) {
  if (h == NULL) return;
  if (h->display != EGL_NO_DISPLAY) {
    eglMakeCurrent(h->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (h->context != EGL_NO_CONTEXT) eglDestroyContext(h->display, h->context);
    eglTerminate(h->display);
    eglReleaseThread();
  }
  free(h);
}

static void write_piece(void* context, void* bytes, int size) {
  FILE* stream = context;
  fwrite(bytes, 1, (size_t)size, stream); /* a failure is told when the stream is closed */
}

scree_result picture_write(const char* path, uint32_t width, uint32_t height, const uint8_t* rgb, scree_error* error) {
  file_replacement file;
  scree_result result = file_replace_begin(path, &file, error);
  if (result != SCREE_OK) return result;
  if (stbi_write_png_to_func(write_piece, file.stream, (int)width, (int)height, 3, rgb, (int)width * 3) == 0) {
    file_replace_abort(&file);
    return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: no memory for the picture", path);
  }
  return file_replace_commit(&file, error);
}
