#include "window/gl.h"

#include <SDL.h>
#include <fmt/format.h>

#include <array>
#include <string>

#include "output/text.h"
#include "output/user_error.h"

namespace psim::view {

GlFunctions gl;

namespace {

template <class Function>
void load(Function& function, const char* name) {
  function = reinterpret_cast<Function>(SDL_GL_GetProcAddress(name));
  if (function == nullptr) throw cli::UserError(fmt::format("OpenGL here lacks {}", name));
}

GLuint compile(GLenum type, const char* source) {
  const GLuint shader = gl.CreateShader(type);
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  GLint good = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good != 0) return shader;
  std::array<char, 1024> log{};
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw cli::UserError(fmt::format("OpenGL refuses a shader: {}", cli::one_line(log.data())));
}

}  // namespace

void load_gl() {
#define X(name) load(gl.name, "gl" #name);
  PSIM_GL_BASE(X)
#undef X
#define X(name, NAME) load(gl.name, "gl" #name);
  PSIM_GL_LATER(X)
#undef X
}

Program::Program(const char* vertex, const char* fragment) : id_(gl.CreateProgram()) {
  const GLuint parts[] = {compile(GL_VERTEX_SHADER, vertex), compile(GL_FRAGMENT_SHADER, fragment)};
  for (const GLuint part : parts) gl.AttachShader(id_, part);
  gl.LinkProgram(id_);
  for (const GLuint part : parts) gl.DeleteShader(part);
  GLint good = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &good);
  if (good != 0) return;
  std::array<char, 1024> log{};
  gl.GetProgramInfoLog(id_, static_cast<GLsizei>(log.size()), nullptr, log.data());
  throw cli::UserError(fmt::format("OpenGL refuses a program: {}", cli::one_line(log.data())));
}

Program::~Program() { gl.DeleteProgram(id_); }

void VertexArray::instanced(GLuint place, GLint count, GLenum type, GLsizei stride, std::size_t offset,
                            bool normalised) const {
  const auto* const at = reinterpret_cast<const void*>(offset);
  gl.EnableVertexAttribArray(place);
  if (type == GL_FLOAT || normalised) {
    gl.VertexAttribPointer(place, count, type, normalised ? GL_TRUE : GL_FALSE, stride, at);
  } else {
    gl.VertexAttribIPointer(place, count, type, stride, at);
  }
  gl.VertexAttribDivisor(place, 1);
}

}  // namespace psim::view
