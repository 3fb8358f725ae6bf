// OpenGL 3.3 as far as it is used here, its functions asked for at run time: nothing links libGL.
#pragma once

#include <SDL_opengl.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace psim::view {

// clang-format off
#define PSIM_GL_BASE(X) \
  X(BindTexture) X(BlendFunc) X(Clear) X(ClearColor) X(DeleteTextures) X(Disable) X(Enable)    \
  X(GenTextures) X(GetString) X(PixelStorei) X(ReadPixels) X(TexImage2D) X(TexParameteri)      \
  X(Viewport)

#define PSIM_GL_LATER(X) \
  X(ActiveTexture, ACTIVETEXTURE) X(AttachShader, ATTACHSHADER) X(BindBuffer, BINDBUFFER)      \
  X(BindVertexArray, BINDVERTEXARRAY) X(BufferData, BUFFERDATA)                                \
  X(CompileShader, COMPILESHADER) X(CreateProgram, CREATEPROGRAM)                              \
  X(CreateShader, CREATESHADER) X(DeleteBuffers, DELETEBUFFERS)                                \
  X(DeleteProgram, DELETEPROGRAM) X(DeleteShader, DELETESHADER)                                \
  X(DeleteVertexArrays, DELETEVERTEXARRAYS) X(DrawArraysInstanced, DRAWARRAYSINSTANCED)        \
  X(EnableVertexAttribArray, ENABLEVERTEXATTRIBARRAY) X(GenBuffers, GENBUFFERS)                \
  X(GenVertexArrays, GENVERTEXARRAYS) X(GetProgramInfoLog, GETPROGRAMINFOLOG)                  \
  X(GetProgramiv, GETPROGRAMIV) X(GetShaderInfoLog, GETSHADERINFOLOG)                          \
  X(GetShaderiv, GETSHADERIV) X(GetUniformLocation, GETUNIFORMLOCATION)                        \
  X(LinkProgram, LINKPROGRAM) X(ShaderSource, SHADERSOURCE) X(TexBuffer, TEXBUFFER)            \
  X(Uniform1f, UNIFORM1F) X(Uniform1i, UNIFORM1I) X(Uniform2f, UNIFORM2F)                      \
  X(Uniform3fv, UNIFORM3FV) X(UseProgram, USEPROGRAM)                                          \
  X(VertexAttribDivisor, VERTEXATTRIBDIVISOR) X(VertexAttribIPointer, VERTEXATTRIBIPOINTER)    \
  X(VertexAttribPointer, VERTEXATTRIBPOINTER)
// clang-format on

struct GlFunctions {
#define X(name) decltype(&::gl##name) name = nullptr;
  PSIM_GL_BASE(X)
#undef X
#define X(name, NAME) PFNGL##NAME##PROC name = nullptr;
  PSIM_GL_LATER(X)
#undef X
};

/// Filled by load_gl, for the one context that there is.
extern GlFunctions gl;

/// Throws UserError if the driver lacks a function.
void load_gl();

/// A linked program. Throws UserError with the driver's words.
class Program {
 public:
  Program(const char* vertex, const char* fragment);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  void use() const { gl.UseProgram(id_); }
  GLint at(const char* uniform) const { return gl.GetUniformLocation(id_, uniform); }

 private:
  GLuint id_ = 0;
};

class Buffer {
 public:
  Buffer() { gl.GenBuffers(1, &id_); }
  ~Buffer() { gl.DeleteBuffers(1, &id_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  GLuint id() const { return id_; }
  template <class T>
  void upload(std::span<const T> data) {
    gl.BindBuffer(GL_ARRAY_BUFFER, id_);
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(data.size_bytes()), data.data(), GL_STREAM_DRAW);
  }

 private:
  GLuint id_ = 0;
};

class VertexArray {
 public:
  VertexArray() { gl.GenVertexArrays(1, &id_); }
  ~VertexArray() { gl.DeleteVertexArrays(1, &id_); }
  VertexArray(const VertexArray&) = delete;
  VertexArray& operator=(const VertexArray&) = delete;
  void bind() const { gl.BindVertexArray(id_); }
  /// One value an instance from the bound array buffer. Integers stay integers unless `normalised`.
  void instanced(GLuint place, GLint count, GLenum type, GLsizei stride = 0, std::size_t offset = 0,
                 bool normalised = false) const;

 private:
  GLuint id_ = 0;
};

}  // namespace psim::view
