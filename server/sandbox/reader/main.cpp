// The spawner and its workers as a small program, embedded in `meshgauge` and executed from there
// (server/sandbox/become_reader.h).
#include "api/formats/read_part.h"
#include "server/sandbox/spawner.h"

int main() { return meshgauge::server::sandbox::run_spawner(meshgauge::api::read_part); }
