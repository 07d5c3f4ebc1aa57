// Opens the stores of a process: embedded in data_dir, or on PostgreSQL and S3, as the settings say.
#pragma once

#include <memory>

#include "engine/result.h"
#include "server/measure/stores.h"
#include "server/settings/settings.h"
#include "server/store/forms/stores.h"

namespace meshgauge::server {

// Precondition: settings come from checked(). An Error names what cannot be opened.
Result<std::unique_ptr<store::AllStores>> open_stores(const Settings& settings);

// Returns the view of the stores that handlers and jobs use. Borrows everything; `maps` may be null.
Stores stores_of(store::AllStores& all, MeshCache& cache, MapCache* maps);

}  // namespace meshgauge::server
