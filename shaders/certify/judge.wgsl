// The winner alone is judged: by its own bounds, and against the second smallest lower bound.

fn judge(s: Slopes, k: Kept) -> Answer {
    var answer = Answer(true, true, NONE, MISS, 0.0, 0.0, 0.0, vec3<f32>(0.0, 0.0, 0.0));
    if ((k.slot & NEAR) == 0u) {
        answer = front_answer(s, front(k.slot), front_more(k.slot));
    }
    return judge_near(s, k, answer);
}

// Hit, root and normal are certain, nobody else can be as near, and the depth is as sharp as promised. A depth that may
// have lost bits below the normal numbers never is.
fn certain(answer: Answer, k: Kept) -> bool {
    let depth = lens.depth + answer.low;
    let sharp = answer.width < lens.tolerance * depth && depth > VANISH;
    return answer.sure && answer.high < k.second && sharp;
}
