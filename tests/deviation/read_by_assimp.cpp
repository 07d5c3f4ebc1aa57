// What assimp finds in a PLY or a GLB, as JSON: its first mesh of triangles.
#include <algorithm>
#include <iostream>

#include <assimp/mesh.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <nlohmann/json.hpp>

int main(int argc, char** argv) {
  Assimp::Importer importer;
  const aiScene* scene = argc == 2 ? importer.ReadFile(argv[1], 0) : nullptr;
  if (!scene) return std::cerr << importer.GetErrorString() << "\n", 1;
  const auto meshes = scene->mMeshes + scene->mNumMeshes;
  const auto found_mesh = std::find_if(scene->mMeshes, meshes,
                                       [](const aiMesh* m) { return m->mPrimitiveTypes == aiPrimitiveType_TRIANGLE; });
  if (found_mesh == meshes || !(*found_mesh)->HasVertexColors(0)) return std::cerr << "no coloured triangles\n", 1;
  const aiMesh& mesh = **found_mesh;
  nlohmann::json found;
  if (const aiNode* node = scene->mRootNode->FindNode("candidate")) {
    const aiMatrix4x4& m = node->mTransformation;
    found["place"] = {m.a4, m.b4, m.c4};
  }
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D& p = mesh.mVertices[v];
    const aiColor4D& c = mesh.mColors[0][v];
    found["positions"].push_back({p.x, p.y, p.z});
    found["colours"].push_back({c.r, c.g, c.b});
  }
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    found["triangles"].push_back(std::vector<unsigned>(face.mIndices, face.mIndices + face.mNumIndices));
  }
  std::cout << found << "\n";
}
