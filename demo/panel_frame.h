// What the panels of scree-view share: Dear ImGui's frame, its looks, and windows for keys and messages. C++.
#ifndef PANEL_FRAME_H
#define PANEL_FRAME_H

#include <imgui.h>

struct GLFWwindow;

// Of windows that only show.
const ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                                ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
                                ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoInputs;

// Call after the window's own callbacks are set: it passes events on to them.
ImGuiContext* panel_frame_create(GLFWwindow* window);
void panel_frame_destroy(ImGuiContext* context);
void panel_frame_begin();
void panel_frame_end();  // draws into the bound framebuffer

// keys: lines of a key, two blanks or more, and what it does.
void panel_keys(const char* keys, bool* open);
// At the bottom left; nothing for an empty text.
void panel_message(const char* text, bool is_error);

#endif
