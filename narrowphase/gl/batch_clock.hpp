#pragma once
#include <epoxy/gl.h>

namespace oncollide::gl {

/// GPU time from start() to stop(), by the GPU's own clock.
class BatchClock {
public:
    BatchClock() { glCreateQueries(GL_TIMESTAMP, 2, queries_); }
    ~BatchClock() { glDeleteQueries(2, queries_); }
    BatchClock(const BatchClock&) = delete;
    BatchClock& operator=(const BatchClock&) = delete;

    void start() { glQueryCounter(queries_[0], GL_TIMESTAMP); }
    void stop() { glQueryCounter(queries_[1], GL_TIMESTAMP); }
    /// Waits for the commands before stop().
    double ms() const
    {
        GLuint64 from = 0, to = 0;
        glGetQueryObjectui64v(queries_[0], GL_QUERY_RESULT, &from);
        glGetQueryObjectui64v(queries_[1], GL_QUERY_RESULT, &to);
        return double(to - from) * 1e-6;
    }

private:
    GLuint queries_[2];
};

/// Waits for a fence; returns the time waited (ms).
double wait_for(GLsync fence);

} // namespace oncollide::gl
