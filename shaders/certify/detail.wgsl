// The data of a sphere of the block by which its hits are certified.
fn projected_detail(slot: u32) -> ProjectedDetail {
    let v = projected[block_pass.count + slot - block_pass.first];
    return ProjectedDetail(vec2<f32>(bitcast<f32>(v.x), bitcast<f32>(v.y)), bitcast<f32>(v.z), bitcast<u32>(v.w));
}
