// The models that a command line names.
#pragma once

#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "firmware/identify/model.h"
#include "firmware/identify/sighting_set.h"

namespace adit::host {

/// Reads them in order. Refuses what LoadModel refuses, more than a box can hold, and two of one name.
inline base::Result<std::vector<identify::Model>> LoadModels(const std::vector<std::string>& files) {
  std::vector<identify::Model> models;
  if (files.size() > identify::kMaxTargets) {
    return base::Error{base::ErrorCode::kUsage, "--model",
                       "is given " + std::to_string(files.size()) + " times; at most " +
                           std::to_string(identify::kMaxTargets) + " are allowed"};
  }
  for (const std::string& file : files) {
    auto model = identify::LoadModel(file);
    if (!model) return model.error();
    for (const identify::Model& other : models) {
      if (other.target.name == model->target.name)
        return base::Error{base::ErrorCode::kOutOfRange, file + ": name",
                           "is '" + model->target.name + "', as in another model; names must differ"};
    }
    models.push_back(std::move(*model));
  }
  return models;
}

}  // namespace adit::host
