// The acceleration structure of the driver: static and moving triangles are an instance each, in world.
enable wgpu_ray_query;

@group(0) @binding(15) var scene_accel: acceleration_structure;
// Triangle of each primitive; an instance's custom data is the index of its first.
@group(0) @binding(16) var<storage, read> order: array<u32>;
