#include "panel_frame.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>

#include <cmath>
#include <cstring>
#include <string>

#include "file.h"

namespace {

const char* const kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

void style() {
  ImGuiStyle& s = ImGui::GetStyle();
  ImGui::StyleColorsDark(&s);
  s.WindowRounding = 6;
  s.FrameRounding = 4;
  s.GrabRounding = 4;
  s.WindowBorderSize = 0;
  s.Colors[ImGuiCol_WindowBg] = ImVec4(0.09f, 0.10f, 0.11f, 0.90f);
  s.Colors[ImGuiCol_TitleBgActive] = ImVec4(0.20f, 0.22f, 0.24f, 1.0f);
  const ImVec4 warm(0.70f, 0.52f, 0.24f, 1.0f);
  s.Colors[ImGuiCol_CheckMark] = s.Colors[ImGuiCol_SliderGrab] = s.Colors[ImGuiCol_SliderGrabActive] = warm;
  s.Colors[ImGuiCol_Header] = ImVec4(0.42f, 0.33f, 0.18f, 0.75f);
  s.Colors[ImGuiCol_HeaderHovered] = ImVec4(0.48f, 0.38f, 0.22f, 0.85f);
  s.Colors[ImGuiCol_HeaderActive] = warm;
  s.Colors[ImGuiCol_Button] = ImVec4(0.24f, 0.26f, 0.28f, 1.0f);
  s.Colors[ImGuiCol_ButtonHovered] = ImVec4(0.36f, 0.33f, 0.27f, 1.0f);
  s.Colors[ImGuiCol_ButtonActive] = warm;
  s.Colors[ImGuiCol_FrameBg] = ImVec4(0.18f, 0.19f, 0.21f, 1.0f);
}

}  // namespace

ImGuiContext* panel_frame_create(GLFWwindow* window) {
  ImGuiContext* context = ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // leaves no file behind
  float scale_x = 1, scale_y = 1;
  glfwGetWindowContentScale(window, &scale_x, &scale_y);
  if (file_exists(kFont)) io.Fonts->AddFontFromFileTTF(kFont, std::floor(14 * scale_x));
  style();
  ImGui::GetStyle().ScaleAllSizes(scale_x);
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
  // A first, empty frame: the questions below may be asked before the first picture.
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  ImGui::EndFrame();
  return context;
}

void panel_frame_destroy(ImGuiContext* context) {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext(context);
}

void panel_frame_begin() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void panel_frame_end() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void panel_keys(const char* keys, bool* open) {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  ImGui::SetNextWindowPos(
      ImVec2(viewport->WorkPos.x + viewport->WorkSize.x * 0.5f, viewport->WorkPos.y + viewport->WorkSize.y * 0.5f),
      ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  if (ImGui::Begin("Keys", open,
                   ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoCollapse |
                       ImGuiWindowFlags_AlwaysAutoResize)) {
    // Two columns by position: the words of keys are aligned with blanks, which a proportional font does not keep.
    for (const char* line = keys; *line != 0;) {
      const std::string text(line, std::strcspn(line, "\n"));
      const size_t gap = text.find("  ", 2);
      ImGui::TextUnformatted(text.substr(0, gap).c_str());
      if (gap != std::string::npos) {
        ImGui::SameLine(150);
        ImGui::TextUnformatted(text.substr(text.find_first_not_of(' ', gap)).c_str());
      }
      line += text.size() + 1;
    }
  }
  ImGui::End();
}

void panel_message(const char* text, bool is_error) {
  if (text[0] == 0) return;
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  ImGui::SetNextWindowPos(ImVec2(viewport->WorkPos.x + 10, viewport->WorkPos.y + viewport->WorkSize.y - 10), ImGuiCond_Always,
                          ImVec2(0, 1));
  ImGui::SetNextWindowBgAlpha(0.75f);
  if (ImGui::Begin("##message", nullptr, kPlain)) {
    if (is_error)
      ImGui::TextColored(ImVec4(1.0f, 0.55f, 0.40f, 1.0f), "%s", text);
    else
      ImGui::TextUnformatted(text);
  }
  ImGui::End();
}
