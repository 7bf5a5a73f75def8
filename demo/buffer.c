/* Text that grows. */
#include "buffer.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void buffer_add_bytes(text_buffer* text, const char* bytes, size_t count) {
  if (text->failed) return;
  if (count >= text->capacity - text->length || text->bytes == NULL) {
    size_t capacity = text->capacity * 2 > text->length + count + 1 ? text->capacity * 2 : text->length + count + 256;
    char* grown = realloc(text->bytes, capacity);
    if (grown == NULL) {
      buffer_free(text);
      text->failed = true;
      return;
    }
    text->bytes = grown;
    text->capacity = capacity;
  }
  memcpy(text->bytes + text->length, bytes, count);
  text->length += count;
  text->bytes[text->length] = '\0';
}

void buffer_add(text_buffer* text, const char* string) {
  buffer_add_bytes(text, string, strlen(string));
}

void buffer_format(text_buffer* text, const char* format, ...) {
  char line[256];
  va_list arguments;
  va_start(arguments, format);
  int length = vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  if (length > 0) buffer_add_bytes(text, line, (size_t)length < sizeof line ? (size_t)length : sizeof line - 1);
}

void buffer_indent(text_buffer* text, uint32_t levels) {
  for (uint32_t i = 0; i < levels; ++i) buffer_add_bytes(text, "  ", 2);
}

void buffer_string(text_buffer* text, const char* string) {
  buffer_add(text, "\"");
  for (const char* c = string; *c != '\0'; ++c) {
    unsigned char code = (unsigned char)*c;
    if (code == '"' || code == '\\') {
      buffer_add_bytes(text, "\\", 1);
      buffer_add_bytes(text, c, 1);
    } else if (code < 0x20) {
      buffer_format(text, "\\u%04x", code);
    } else {
      buffer_add_bytes(text, c, 1);
    }
  }
  buffer_add(text, "\"");
}

/* JSON has a point whatever the locale has. */
static void add_decimal(text_buffer* text, char* number) {
  for (char* c = number; *c != '\0'; ++c) {
    if (*c == ',') *c = '.';
  }
  buffer_add(text, number);
}

void buffer_number(text_buffer* text, double value) {
  char number[32];
  if (!isfinite(value)) value = 0;
  for (int digits = 15; digits <= 17; ++digits) {
    snprintf(number, sizeof number, "%.*g", digits, value + 0.0);
    if (strtod(number, NULL) == value) break;
  }
  add_decimal(text, number);
}

void buffer_float(text_buffer* text, float value) {
  char number[32];
  if (!isfinite(value)) value = 0;
  for (int digits = 6; digits <= 9; ++digits) {
    snprintf(number, sizeof number, "%.*g", digits, (double)value + 0.0);
    if (strtof(number, NULL) == value) break;
  }
  add_decimal(text, number);
}

char* buffer_take(text_buffer* text, size_t* size) {
  char* bytes = text->bytes;
  if (size != NULL) *size = text->length;
  text->bytes = NULL;
  text->length = text->capacity = 0;
  return bytes;
}

void buffer_free(text_buffer* text) {
  free(text->bytes);
  text->bytes = NULL;
  text->length = text->capacity = 0;
}
