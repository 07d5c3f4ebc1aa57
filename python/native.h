// The C interface for the Python package, which calls it by ctypes (python/meshgauge/_native.py).
//
// A job compares two meshes on a thread of its own, so that the caller can wait in short steps and react to signals
// between them. Options and answers are the JSON documents of the service: api/options/request.h,
// api/result/response.h, api/base/problem.h.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// One mesh: a file (`path`), the content of a file (`bytes`), or arrays (`positions` and `triangles`; a point cloud has
// no triangles). The fields of the other two forms are null or 0. Everything is borrowed until the job has ended. The
// arrays are copied when it begins: what another thread changes meanwhile is measured in part or not at all.
typedef struct {
  const char* path;
  const void* bytes;
  size_t byte_count;
  const double* positions;  // x, y, z of each vertex
  size_t vertices;
  const uint32_t* triangles;  // three indices of vertices for each triangle
  size_t triangle_count;
} meshgauge_mesh;

typedef struct meshgauge_job meshgauge_job;

// Runs the command line, without the subcommands of the service. Returns the exit code.
int meshgauge_main(int argc, char** argv);

// The version, such as "0.2.0".
const char* meshgauge_version(void);

// Returns a job that does not run yet; NULL: out of memory.
meshgauge_job* meshgauge_create(void);

// Begins to compare. `options`: a JSON document. `at_vertices`: not 0: measure the distance of each vertex of a as
// well, which has the time of the comparison once more. Returns 0 when no thread can be started. Call once for each
// job.
int meshgauge_start(meshgauge_job* job, const meshgauge_mesh* a, const meshgauge_mesh* b, const char* options,
                    int at_vertices);

// Waits at most `milliseconds`. Returns 1 when the job has ended, else 0.
int meshgauge_wait(meshgauge_job* job, int milliseconds);

// Returns the result document of a job that has ended, or NULL with a problem document in `*problem`. Both are valid
// until meshgauge_free().
const char* meshgauge_answer(const meshgauge_job* job, const char** problem);

// Returns the number of vertices whose distances a job that has ended measured, with these in `*distances`, and in
// `*with_signs` DeviationMap::signed_distance() of each (api/map/deviation_map.h), or NULL. Valid until
// meshgauge_free().
size_t meshgauge_at_vertices(const meshgauge_job* job, const double** distances, const double** with_signs);

// Cancels the job if it still runs and waits for its end. May be called more than once.
void meshgauge_stop(meshgauge_job* job);

// Stops the job and frees it.
void meshgauge_free(meshgauge_job* job);

#ifdef __cplusplus
}
#endif
