"""What nodes hear of robot and shoes: joint angles, readings, standing still, armed or not."""
